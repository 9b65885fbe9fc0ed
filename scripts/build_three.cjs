// Build phonanim/viewer/three.js: the parts of three.js (MIT) that the HTML viewer needs, as one plain script.
//
//     npm install three@0.187.0 esbuild@0.28
//     NODE_PATH=node_modules node scripts/build_three.cjs
const fs = require("fs");
const path = require("path");
const esbuild = require("esbuild");

const NAMES = [
  "Box3", "Color", "DirectionalLight", "HemisphereLight", "NeutralToneMapping", "PCFShadowMap",
  "PerspectiveCamera", "Scene", "Vector3", "WebGLRenderer",
];
const ENTRY = `
export { ${NAMES.join(", ")} } from "three";
export { GLTFLoader } from "three/examples/jsm/loaders/GLTFLoader.js";
export { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
`;

const modules = (process.env.NODE_PATH || "node_modules").split(path.delimiter)[0];
const folder = path.resolve(modules, "three");
const { version } = JSON.parse(fs.readFileSync(path.join(folder, "package.json")));
const licence = fs.readFileSync(path.join(folder, "LICENSE"), "utf8").trim();

esbuild.buildSync({
  stdin: { contents: ENTRY, resolveDir: path.dirname(path.resolve(modules)) },
  bundle: true,
  minify: true,
  format: "iife",
  globalName: "THREE",
  legalComments: "none",
  banner: { js: `/* three.js ${version}, https://threejs.org\n\n${licence}\n*/` },
  outfile: path.join(__dirname, "..", "phonanim", "viewer", "three.js"),
});
