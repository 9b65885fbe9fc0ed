"""Check that Babylon.js plays a GLB as the take says: the weights of its shapes at some frames.

    npm install babylonjs babylonjs-loaders
    phonanim animate line.TextGrid -o line.npz -o line.glb
    python scripts/check_babylon.py line.npz line.glb

Needs no browser: Babylon's NullEngine runs in Node. Run it where node_modules lies, or name it in NODE_PATH.
Ends with status 1 when a weight is more than 0.00001 off.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np

from phonanim.exporters import load

FAR = 1e-5
FRAMES = 24
SCRIPT = """
const fs = require('fs');
const BABYLON = (globalThis.BABYLON = require('babylonjs'));
const { GLTFFileLoader } = require('babylonjs-loaders');
const { SceneLoader } = BABYLON;
if (!SceneLoader.IsPluginForExtensionAvailable('.glb')) SceneLoader.RegisterPlugin(new GLTFFileLoader());
console.log = () => {};
(async () => {
  const scene = new BABYLON.Scene(new BABYLON.NullEngine());
  const data = 'data:;base64,' + fs.readFileSync(process.argv[2]).toString('base64');
  await SceneLoader.AppendAsync('', data, scene, undefined, '.glb');
  const [group] = scene.animationGroups;
  const rate = group.targetedAnimations[0].animation.framePerSecond;
  const shapes = scene.meshes.map((mesh) => mesh.morphTargetManager).filter(Boolean);
  group.start(false);
  group.pause();
  const found = JSON.parse(process.argv[3]).map((time) => {
    group.goToFrame(time * rate);
    const weights = (of) => Array.from({ length: of.numTargets }, (_, n) => of.getTarget(n));
    return shapes.map((of) => weights(of).map((target) => [target.name, target.influence]));
  });
  process.stdout.write('\\n' + JSON.stringify({ version: BABYLON.Engine.Version, found }));
})().catch((error) => { process.stderr.write(String(error.message).slice(0, 300)); process.exit(1); });
"""


def main() -> None:
    """Compare the weights of both."""
    take, path = load(Path(sys.argv[1])), Path(sys.argv[2]).resolve()
    frames = np.linspace(0, len(take.values) - 1, FRAMES).astype(int)
    times = json.dumps((take.start + frames / take.fps).tolist())
    command = ["node", "-", str(path), times]
    done = subprocess.run(command, input=SCRIPT, capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(done.stderr.strip())
    shown = json.loads(done.stdout.splitlines()[-1])
    worst, count = 0.0, 0
    for frame, meshes in zip(frames, shown["found"], strict=True):
        for name, weight in (pair for mesh in meshes for pair in mesh):
            if name in take.channels:
                count += 1
                worst = max(worst, abs(weight - float(take.channel(name)[frame])))
    print(
        f"Babylon.js {shown['version']}: {count} weights in {FRAMES} frames, largest difference {worst:.2g}"
    )
    sys.exit(not count or worst > FAR)


if __name__ == "__main__":
    main()
