// The heads, one beside the other, each moved by its take.

const FIELD = 26; // degrees from bottom to top
const SHADED = 1.3; // of the height of the picture: what casts shadows is within it
const AROUND = 1.85, ALONE = 4.4; // of the height of what moves, with the eyes and without
const UP = new THREE.Vector3(0, 1, 0);
// Colour, strength, and place from the middle of the head in its heights: to the left, up, ahead of the face.
const LIGHTS = [[0xfff1e2, 2.6, -0.9, 1.1, 1.7], [0xc4d4ff, 0.7, 1.7, 0.2, 0.9], [0xffffff, 1.6, 1.0, 1.0, -1.5]];
const LIDS = /blink|eyes?_?clos|まばたき/i;

class Stage {
  constructor(section, takes) {
    this.section = section;
    this.takes = takes;
    this.heads = [];
    this.renderer = new THREE.WebGLRenderer({ canvas: section.querySelector("canvas"), antialias: true, preserveDrawingBuffer: true });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.toneMapping = THREE.NeutralToneMapping;
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = THREE.PCFShadowMap;
    this.camera = new THREE.PerspectiveCamera(FIELD, 1, 0.01, 100);
    this.controls = new THREE.OrbitControls(this.camera, this.renderer.domElement);
  }

  async load(bytes) {
    for (const take of this.takes) {
      const gltf = await new THREE.GLTFLoader().parseAsync(bytes.slice().buffer, "");
      this.heads.push(this.lit(gltf, take));
    }
    this.frame(this.heads[0]);
  }

  // A scene with one head and its lights: key from the upper left of its face, a cool fill, a rim from behind.
  lit({ scene: model, parser }, take) {
    const scene = new THREE.Scene();
    scene.background = new THREE.Color(0x30343c);
    scene.add(model, new THREE.HemisphereLight(0xdfe6f2, 0x4a3a32, 0.9));
    scene.updateMatrixWorld(true);
    const morphs = [];
    model.traverse((part) => {
      part.castShadow = part.receiveShadow = Boolean(part.isMesh);
      if (part.isMesh) finish(part.material);
      if (part.morphTargetInfluences) morphs.push(...binds(part, parser.associations.get(part)?.meshes, take));
    });
    const head = { scene, model, take, morphs, neck: neck(model, take), face: faceOf(model, morphs) };
    head.lights = LIGHTS.map(([color, strength]) => new THREE.DirectionalLight(color, strength));
    head.lights.forEach((light) => scene.add(light, light.target));
    this.shine(head);
    return head;
  }

  // Place the lights around a face as it looks. Shadows are as fine as the face, also of whole bodies.
  shine({ model, lights, face: { ahead, centre, tall } }) {
    const size = Math.min(new THREE.Box3().setFromObject(model).getSize(new THREE.Vector3()).y, SHADED * tall);
    lights.forEach((light, number) => {
      light.position.set(...LIGHTS[number].slice(2)).applyAxisAngle(UP, ahead).multiplyScalar(size).add(centre);
      light.target.position.copy(centre);
      if (number === 0) this.shade(light, size);
    });
  }

  shade(light, size) {
    const reach = size * 0.75;
    light.castShadow = true;
    light.shadow.mapSize.set(2048, 2048);
    light.shadow.normalBias = size * 0.004;
    light.shadow.radius = 3;
    Object.assign(light.shadow.camera, { left: -reach, right: reach, top: reach, bottom: -reach, near: size * 0.1, far: size * 5 });
  }

  // Look at the face from its front.
  frame({ face }) {
    const distance = face.tall / 2 / Math.tan((FIELD * Math.PI) / 360);
    const away = new THREE.Vector3(-0.22 * distance, 0, distance).applyAxisAngle(UP, face.ahead);
    this.controls.target.copy(face.centre);
    this.camera.position.copy(face.centre).add(away);
    this.camera.near = distance / 50;
    this.camera.far = distance * 50;
    this.controls.update();
  }

  draw(time) {
    const { clientWidth: width, clientHeight: height } = this.section;
    this.renderer.setSize(width, height, false);
    this.renderer.setScissorTest(true);
    const share = width / this.heads.length;
    this.camera.aspect = share / height;
    this.camera.updateProjectionMatrix();
    this.heads.forEach(({ scene, take, morphs, neck }, number) => {
      if (neck) neck(time);
      for (const { part, target } of morphs) part.morphTargetInfluences[target] = 0;
      for (const { part, target, channel, share } of morphs) part.morphTargetInfluences[target] += share * take.at(channel, time);
      for (const { part, target } of morphs) part.morphTargetInfluences[target] = Math.max(part.morphTargetInfluences[target], 0);
      this.renderer.setViewport(number * share, 0, share, height);
      this.renderer.setScissor(number * share, 0, share, height);
      this.renderer.render(scene, this.camera);
    });
  }
}

// What the page shows of a head: what the bound targets move, with the eyes, and where it looks.
function faceOf(model, morphs) {
  const box = new THREE.Box3();
  for (const { part, target } of morphs) box.union(reach(part, target));
  const lids = eyes(model);
  const both = box.clone().union(lids);
  const height = both.max.y - both.min.y;
  const tall = (lids.isEmpty() ? ALONE : AROUND) * height;
  const centre = both.getCenter(new THREE.Vector3());
  const ahead = facing(model, centre.clone(), height);
  centre.y += lids.isEmpty() ? 0.5 * height : 0.06 * tall;
  return { centre, tall, ahead };
}

// How the shipped head's skin and eyes shine beyond what glTF says: light that bleeds red into the shade of the
// skin, and the reflection of a window in wet eyes. Other materials are left as they are.
const FINISH = {
  skin: `
    #if NUM_DIR_LIGHTS > 0
    for (int i = 0; i < NUM_DIR_LIGHTS; i++) {
      float facing = dot(normal, directionalLights[i].direction);
      vec3 bled = clamp((facing + vec3(0.34, 0.14, 0.08)) / (1.0 + vec3(0.34, 0.14, 0.08)), 0.0, 1.0) - clamp(facing, 0.0, 1.0);
      reflectedLight.directDiffuse += 0.6 * max(bled, 0.0) * directionalLights[i].color * BRDF_Lambert(diffuseColor.rgb);
    }
    #endif`,
  eye: `
    vec3 half0 = normalize(normalize(vViewPosition) + normalize(vec3(-0.42, 0.36, 0.82)));
    reflectedLight.directSpecular += 0.9 * smoothstep(0.986, 0.993, dot(normal, half0));`,
};

function finish(material) {
  const kind = { skin: "skin", eye_l: "eye", eye_r: "eye" }[material.name];
  if (!kind) return;
  material.onBeforeCompile = (shader) => {
    shader.fragmentShader = shader.fragmentShader.replace("#include <lights_fragment_end>", `#include <lights_fragment_end>\n${FINISH[kind]}`);
  };
  material.customProgramCacheKey = () => kind;
}

// How the bone of a model's head turns with a take, in degrees about x, y and z of the world; none without either.
function neck(model, take) {
  const channels = ["headPitch", "headYaw", "headRoll"].map((name) => take.channels.indexOf(name));
  let bone;
  model.traverse((part) => {
    if (!bone && part.isBone && /(^|[:_.\s])head$/i.test(part.name)) bone = part;
  });
  if (!bone || channels.every((channel) => channel < 0)) return undefined;
  model.updateMatrixWorld(true);
  const parent = bone.parent.getWorldQuaternion(bone.quaternion.clone());
  const rest = bone.quaternion.clone();
  const back = parent.clone().invert();
  const angles = bone.rotation.clone();
  const turn = bone.quaternion.clone();
  return (time) => {
    const [x, y, z] = channels.map((channel) => (channel < 0 ? 0 : (take.at(channel, time) * Math.PI) / 180));
    turn.setFromEuler(angles.set(x, y, z, "YXZ"));
    bone.quaternion.copy(back).multiply(turn).multiply(parent).multiply(rest);
  };
}

// Which targets of a part of a mesh follow which channels of a take, as found when the page was made.
function binds(part, number, take) {
  const own = take.targets.filter(([, mesh, target]) => mesh === number && target < part.morphTargetInfluences.length);
  return own.map(([channel, , target, share]) => ({ part, target, channel, share }));
}

// The box around what the shapes that close the eyes move, empty without one.
function eyes(model) {
  const box = new THREE.Box3();
  model.traverse((part) => {
    for (const [name, target] of Object.entries(part.morphTargetDictionary || {})) {
      if (LIDS.test(name)) box.union(reach(part, target));
    }
  });
  return box;
}

// The quarter turn from z to where the face at a place looks: away from the middle of its head.
function facing(model, face, height) {
  const box = new THREE.Box3();
  const point = new THREE.Vector3();
  model.traverse((part) => {
    for (let i = 0; part.isMesh && i < part.geometry.attributes.position.count; i++) {
      part.getVertexPosition(i, point).applyMatrix4(part.matrixWorld);
      if (Math.abs(point.y - face.y) < height / 2 && point.distanceTo(face) < 3 * height) box.expandByPoint(point);
    }
  });
  const ahead = face.clone().sub(box.getCenter(point));
  return (Math.round(Math.atan2(ahead.x, ahead.z) / (Math.PI / 2)) * Math.PI) / 2;
}

// The box around the vertices that a target moves by a fifth or more of its largest move.
function reach(part, target) {
  const moves = part.geometry.morphAttributes.position[target];
  const move = new THREE.Vector3();
  const lengths = Array.from({ length: moves.count }, (_, i) => move.fromBufferAttribute(moves, i).length());
  const most = lengths.reduce((a, b) => Math.max(a, b), 0);
  const box = new THREE.Box3();
  lengths.forEach((length, i) => {
    if (most > 0 && length >= 0.2 * most) box.expandByPoint(part.getVertexPosition(i, move).applyMatrix4(part.matrixWorld));
  });
  return box;
}
