// Mark the points of a face: click on the head, correct, and save the table that `phonanim rig fit` reads.

const $ = (id) => document.getElementById(id);
const data = JSON.parse($("data").textContent);
const take = { channels: ["open"], targets: data.targets, at: () => ($("open").checked ? 1 : 0) };
const stage = new Stage($("stage"), [take]);
const STILL = 5; // pixels within which a press and its release are a click
const QUARTER = Math.PI / 2;
const found = new Map(); // landmark -> { corners, weights }: rows of the file's points, and shares of them
const order = []; // landmarks in the order in which they were marked
let now = 0;
let parts = [];
let drawn = "";

// The parts of the head with the row of their first point and their points in the world as they are shown.
function readParts() {
  const { model } = stage.heads[0];
  model.updateMatrixWorld(true);
  const meshes = [];
  model.traverse((part) => { if (part.isMesh) meshes.push(part); });
  parts = meshes.map((part, number) => {
    const count = part.geometry.attributes.position.count;
    const points = new Float64Array(3 * count);
    const point = new THREE.Vector3();
    for (let i = 0; i < count; i++) part.getVertexPosition(i, point).applyMatrix4(part.matrixWorld).toArray(points, 3 * i);
    return { first: data.first[number], points, faces: part.geometry.index.array };
  });
}

// The nearest triangle that a ray hits, with the shares of its corners; none where it hits nothing.
function hit(origin, along) {
  let best = null;
  for (const { first, points, faces } of parts) {
    for (let f = 0; f < faces.length; f += 3) {
      const met = cross(origin, along, points, 3 * faces[f], 3 * faces[f + 1], 3 * faces[f + 2]);
      if (met && (!best || met.far < best.far)) best = { ...met, corners: [0, 1, 2].map((k) => first + faces[f + k]) };
    }
  }
  return best;
}

// Möller and Trumbore 1997: how far along a ray meets a triangle of points, and the shares of its corners.
function cross(o, d, p, a, b, c) {
  const ex = p[b] - p[a], ey = p[b + 1] - p[a + 1], ez = p[b + 2] - p[a + 2];
  const fx = p[c] - p[a], fy = p[c + 1] - p[a + 1], fz = p[c + 2] - p[a + 2];
  const hx = d.y * fz - d.z * fy, hy = d.z * fx - d.x * fz, hz = d.x * fy - d.y * fx;
  const size = ex * hx + ey * hy + ez * hz;
  if (size === 0) return null;
  const sx = o.x - p[a], sy = o.y - p[a + 1], sz = o.z - p[a + 2];
  const u = (sx * hx + sy * hy + sz * hz) / size;
  if (u < 0 || u > 1) return null;
  const qx = sy * ez - sz * ey, qy = sz * ex - sx * ez, qz = sx * ey - sy * ex;
  const v = (d.x * qx + d.y * qy + d.z * qz) / size;
  if (v < 0 || u + v > 1) return null;
  const far = (fx * qx + fy * qy + fz * qz) / size;
  return far > 0 ? { far, weights: [1 - u - v, u, v] } : null;
}

function mark(x, y) {
  const box = $("stage").getBoundingClientRect();
  const { camera } = stage;
  const along = new THREE.Vector3((2 * (x - box.left)) / box.width - 1, 1 - (2 * (y - box.top)) / box.height, 0.5);
  along.unproject(camera).sub(camera.position);
  const met = hit(camera.position, along);
  if (!met) return;
  const { landmark } = data.points[now];
  found.set(landmark, met);
  order.push(landmark);
  const free = data.points.findIndex((point) => !found.has(point.landmark));
  choose(free < 0 ? now : free);
}

// Where a point of the head is on the screen, in pixels of the stage.
function pixel({ corners, weights }) {
  const { first, points } = parts.find((part) => corners[0] >= part.first && corners[0] < part.first + part.points.length / 3);
  const spot = [0, 1, 2].map((axis) => corners.reduce((sum, row, k) => sum + weights[k] * points[3 * (row - first) + axis], 0));
  const at = new THREE.Vector3(...spot).project(stage.camera);
  const { clientWidth: width, clientHeight: height } = $("stage");
  return [((at.x + 1) / 2) * width, ((1 - at.y) / 2) * height];
}

function choose(place) {
  now = place;
  const { name, needed, opened } = data.points[now];
  if (data.opens && opened !== $("open").checked) opening(opened);
  const missing = data.points.filter((point) => point.needed && !found.has(point.landmark)).length;
  $("ask").textContent = missing || !found.has(data.points[now].landmark)
    ? `${name}${needed ? "" : " (helps, but is not needed)"}` : "all marked; save, or choose one to mark it anew";
  $("count").value = missing ? `${missing} to mark` : "ready to save";
  $("save").disabled = missing > 0;
  [...$("points").children].forEach(({ firstChild: button }, number) => {
    button.setAttribute("aria-current", number === now);
    button.firstChild.textContent = found.has(data.points[number].landmark) ? "●" : data.points[number].needed ? "○" : "·";
  });
  $("points").children[now].scrollIntoView({ block: "nearest" });
}

// Open or close the mouth, for lips that touch when it is closed.
function opening(wide) {
  $("open").checked = wide;
  stage.draw(0);
  readParts();
}

function table() {
  const rows = data.points.filter(({ landmark }) => found.has(landmark)).map(({ landmark }) => {
    const { corners, weights } = found.get(landmark);
    const shares = weights.map((weight) => Number(weight.toFixed(6)));
    shares[0] = Number((1 - shares[1] - shares[2]).toFixed(6));
    return [landmark, ...corners, ...shares].join(",");
  });
  return [data.header, ...rows, ""].join("\n");
}

function save() {
  const link = document.createElement("a");
  link.href = `data:text/csv;charset=utf-8,${encodeURIComponent(table())}`;
  link.download = data.saved;
  link.click();
  $("next").innerHTML = "Saved. Next: <code></code>";
  $("next").firstElementChild.textContent = data.command;
}

function undo() {
  const last = order.pop();
  if (last === undefined) return;
  if (!order.includes(last)) found.delete(last);
  choose(data.points.findIndex(({ landmark }) => landmark === last));
}

// Look at the head from a side, in degrees about the vertical.
function look(degrees) {
  const { camera, controls } = stage;
  const away = camera.position.distanceTo(controls.target);
  const angle = stage.heads[0].face.ahead + (degrees * Math.PI) / 180;
  camera.position.set(Math.sin(angle), 0, Math.cos(angle)).multiplyScalar(away).add(controls.target);
  controls.update();
}

// Turn the model about an axis of the world, and look at its face again.
function rotate(x, y, z) {
  const [head] = stage.heads;
  const { model, morphs } = head;
  const turn = model.quaternion.clone().setFromEuler(model.rotation.clone().set(x, y, z));
  model.quaternion.premultiply(turn);
  model.updateMatrixWorld(true);
  head.face = faceOf(model, morphs);
  stage.shine(head);
  stage.frame(head);
  look(0);
  readParts();
}

// Drawn only after something has changed: a head in software takes a second.
function draw() {
  requestAnimationFrame(draw);
  const { clientWidth, clientHeight } = $("stage");
  const state = [clientWidth, clientHeight, now, found.size, order.length, $("open").checked, ...stage.camera.position, ...stage.controls.target, ...stage.heads[0].model.quaternion].join();
  if (state === drawn) return;
  drawn = state;
  stage.draw(0);
  for (const { landmark } of data.points) {
    const shown = $(`mark-${landmark}`);
    shown.hidden = !found.has(landmark);
    if (shown.hidden) continue;
    const [x, y] = pixel(found.get(landmark));
    shown.style.transform = `translate(${x}px, ${y}px)`;
    shown.className = landmark === data.points[now].landmark ? "now" : "";
  }
  document.documentElement.dataset.drawn = found.size;
}

function list() {
  data.points.forEach(({ landmark, name }, number) => {
    const row = document.createElement("li");
    row.innerHTML = "<button><i></i><span></span></button>";
    row.firstChild.lastChild.textContent = name;
    row.firstChild.addEventListener("click", () => choose(number));
    $("points").append(row);
    const shown = document.createElement("b");
    shown.id = `mark-${landmark}`;
    $("marks").append(shown);
  });
}

let pressed = null;
$("stage").addEventListener("pointerdown", (event) => { pressed = event.isPrimary ? [event.clientX, event.clientY] : null; });
$("stage").addEventListener("pointerup", (event) => {
  const still = pressed && Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) < STILL;
  if (still && event.button === 0) mark(event.clientX, event.clientY);
  pressed = null;
});
$("open").addEventListener("change", () => opening($("open").checked));
$("save").addEventListener("click", save);
$("undo").addEventListener("click", undo);
$("front").addEventListener("click", () => look(0));
$("right").addEventListener("click", () => look(-70));
$("left").addEventListener("click", () => look(70));
$("turn").addEventListener("click", () => rotate(0, 0, -QUARTER));
$("tilt").addEventListener("click", () => rotate(QUARTER, 0, 0));
$("opener").hidden = !data.opens;
window.phonanim = { stage, pixel, table, found };
list();
for (const { landmark, corners, weights } of data.marked) found.set(landmark, { corners, weights });
stage.load(bytesOf(data.head)).then(() => {
  look(0);
  readParts();
  choose(Math.max(0, data.points.findIndex(({ landmark }) => !found.has(landmark))));
  draw();
});
