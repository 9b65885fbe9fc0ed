// Play a VRM animation on a VRM avatar in three-vrm, and print the weights after `update()` at some instants.
//
//     npm install three @pixiv/three-vrm @pixiv/three-vrm-animation      (anywhere; NODE_PATH names its node_modules)
//     NODE_PATH=node_modules node scripts/check_vrma.mjs avatar.vrm line.vrma line.json
//
// line.json is the same animation: every expression of the avatar that it moves must have its value, within 1e-4.
import fs from "node:fs";
import path from "node:path";
import { pathToFileURL } from "node:url";

// The ES module of a package in the folder node_modules.
function load(name, file) {
  const folder = path.resolve(process.env.NODE_PATH ?? "node_modules", name);
  const { exports, module } = JSON.parse(fs.readFileSync(path.join(folder, "package.json")));
  return import(pathToFileURL(path.join(folder, file ?? exports["."].import ?? module)).href);
}

const THREE = await load("three");
const { VRMLoaderPlugin } = await load("@pixiv/three-vrm");
const animation = await load("@pixiv/three-vrm-animation");
const { GLTFLoader } = await load("three", "examples/jsm/loaders/GLTFLoader.js");
globalThis.self ??= globalThis; // the loader of textures looks for it

function parse(file, plugin) {
  const loader = new GLTFLoader();
  loader.register(plugin);
  const data = fs.readFileSync(file);
  return loader.parseAsync(data.buffer.slice(data.byteOffset, data.byteOffset + data.byteLength), "");
}

const [avatar, clip, take] = process.argv.slice(2);
const vrm = (await parse(avatar, (parser) => new VRMLoaderPlugin(parser))).userData.vrm;
const motion = (await parse(clip, (parser) => new animation.VRMAnimationLoaderPlugin(parser))).userData.vrmAnimations[0];
const mixer = new THREE.AnimationMixer(vrm.scene);
const action = mixer.clipAction(animation.createVRMAnimationClip(motion, vrm));
action.setLoop(THREE.LoopOnce).clampWhenFinished = true;
action.play();

const told = JSON.parse(fs.readFileSync(take));
const plain = (name) => name.replace(/[\s_]/g, "").toLowerCase();
const curves = new Map(Object.entries(told.curves).map(([name, curve]) => [plain(name), curve]));
const moved = vrm.expressionManager.expressions.filter((one) => curves.has(plain(one.expressionName)));
let worst = 0;
for (let frame = 0; frame < told.frames; frame++) {
  mixer.setTime(frame / told.fps);
  vrm.update(0);
  for (const one of moved) {
    const value = Math.min(Math.max(curves.get(plain(one.expressionName))[frame], 0), 1);
    worst = Math.max(worst, Math.abs(one.weight - value));
  }
}
const meshes = [];
vrm.scene.traverse((object) => { if (object.morphTargetInfluences) meshes.push(object); });
const most = Math.max(...meshes.flatMap((mesh) => mesh.morphTargetInfluences));
const head = vrm.humanoid.getNormalizedBoneNode("head");
console.log(`${moved.length} expressions, largest difference ${worst.toExponential(1)}; ` +
  `largest weight of a mesh in the last frame ${most.toFixed(3)}; head ${head.quaternion.toArray().map((x) => x.toFixed(4))}`);
process.exit(moved.length && worst < 1e-4 ? 0 : 1);
