"""Check that three.js poses a GLB as phonanim draws the take: shapes, skin and head, at some instants.

    npm install three
    phonanim animate line.TextGrid -o line.npz -o line.glb
    python scripts/check_three.py line.npz line.glb

Run it where node_modules lies. Ends with status 1 when a point is more than 0.001 mm off.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np

from phonanim.exporters import load
from phonanim.rig.head import load_dressed_head
from phonanim.rig.neck import turned, turns_of

FAR = 1e-6  # metres
FRAMES = 12
SCRIPT = """
import fs from 'fs';
import * as THREE from 'three';
import { GLTFLoader } from 'three/examples/jsm/loaders/GLTFLoader.js';
globalThis.self = globalThis;
const data = fs.readFileSync(process.argv[2]);
const bytes = data.buffer.slice(data.byteOffset, data.byteOffset + data.byteLength);
const gltf = await new GLTFLoader().parseAsync(bytes, '');
const mixer = new THREE.AnimationMixer(gltf.scene);
for (const clip of gltf.animations) {
  const action = mixer.clipAction(clip).setLoop(THREE.LoopOnce);
  action.clampWhenFinished = true;
  action.play();
}
const found = JSON.parse(process.argv[3]).map((time) => {
  mixer.setTime(time);
  gltf.scene.updateMatrixWorld(true);
  const points = [], point = new THREE.Vector3();
  gltf.scene.traverse((node) => {
    for (let i = 0; node.isMesh && i < node.geometry.attributes.position.count; i++)
      points.push(node.getVertexPosition(i, point).applyMatrix4(node.matrixWorld).toArray());
  });
  return points;
});
console.log(JSON.stringify({ revision: THREE.REVISION, found }));
"""


def main() -> None:
    """Compare the points of both."""
    take, path = load(Path(sys.argv[1])), Path(sys.argv[2]).resolve()
    frames = np.linspace(0, len(take.values) - 1, FRAMES).astype(int)
    times = json.dumps((frames / take.fps).tolist())
    command = ["node", "--input-type=module", "-", str(path), times]
    done = subprocess.run(command, input=SCRIPT, capture_output=True, text=True, check=True)
    shown = json.loads(done.stdout)
    head = load_dressed_head()
    weights = head.weights(take.values, take.channels)[frames]
    turns = turns_of(take.values, take.channels)
    worst = 0.0
    for row, points in enumerate(shown["found"]):
        turn = None if turns is None else turns[frames[row]]
        worst = max(worst, float(np.abs(turned(head.shape(weights[row]), head.neck, turn) - points).max()))
    print(f"three.js r{shown['revision']}: {FRAMES} frames, points within {1000 * worst:.2g} mm")
    sys.exit(worst > FAR)


if __name__ == "__main__":
    main()
