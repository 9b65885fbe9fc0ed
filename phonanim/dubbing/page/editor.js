// The hands on a line: the phone that is picked, boundaries that are dragged, curves that are drawn, and keys.

const NEAR = matchMedia("(pointer: coarse)").matches ? 14 : 6; // pixels to a boundary
const STEP = 0.005; // seconds that a key moves a boundary
const bench = buildBench();
let picked = -1, drag = null, drawing = false, looped = null;

function phoneRow() {
  const words = takes[0].words.length ? ROWS.words : 0;
  const top = ROWS.ruler + (timeline.wave ? ROWS.wave : 0) + words;
  return { top, bottom: top + ROWS.phones };
}

function placeOf(event) {
  const box = timeline.canvas.getBoundingClientRect();
  return { x: event.clientX - box.left, y: event.clientY - box.top };
}

function phoneAt(time) {
  return takes[0].phones.findIndex(([, start, end]) => start <= time && time < end);
}

function pick(place, go = true) {
  const phones = takes[0].phones;
  picked = Math.min(Math.max(place, 0), phones.length - 1);
  if (go && phones[picked]) {
    seek(phones[picked][1]);
    timeline.follow(player.time);
  }
  if (looped) loopPicked();
}

// The boundary under the pointer: [phone, edge], where edge 1 is its start.
function edgeAt({ x, y }) {
  const { top, bottom } = phoneRow();
  if (y < top || y > bottom) return null;
  let best = null, least = NEAR;
  takes[0].phones.forEach((phone, place) => {
    for (const edge of [2, 1]) {
      const away = Math.abs(timeline.x(phone[edge]) - x);
      if (away <= least && !(edge === 1 && place === 0 && phone[1] === 0)) [best, least] = [[place, edge], away];
    }
  });
  return best;
}

function grab(event) {
  const place = placeOf(event);
  if (drawing && place.y > phoneRow().bottom && timeline.shown.length) {
    drag = { channel: chosenCurve(), points: [] };
    drawPoint(place);
  } else {
    const edge = edgeAt(place);
    if (!edge) {
      const { top, bottom } = phoneRow();
      if (place.y >= top && place.y <= bottom) pick(phoneAt(timeline.time(place.x)), false);
      return;
    }
    drag = { edge, from: takes[0].phones[edge[0]][edge[1]] };
    picked = edge[0];
  }
  event.stopPropagation();
  timeline.canvas.setPointerCapture(event.pointerId);
}

function follow(event) {
  const place = placeOf(event);
  timeline.canvas.style.cursor = drawing ? "cell" : edgeAt(place) || drag?.edge ? "ew-resize" : "";
  if (!drag) return;
  event.stopPropagation();
  if (drag.points) drawPoint(place);
  else moveEdge(...drag.edge, timeline.time(place.x));
}

function letGo(event) {
  if (!drag) return;
  event.stopPropagation();
  const { points, channel, edge, from } = drag;
  drag = null;
  if (points) drawCurve(channel, points.sort((a, b) => a[0] - b[0]));
  else if (takes[0].phones[edge[0]][edge[1]] !== from) correctEdge(...edge);
}

function correctEdge(place, edge) {
  const phone = takes[0].phones[place];
  correct(`${phone[0] || "silence"} ${edge === 1 ? "begins" : "ends"} at ${phone[edge].toFixed(3)} s`);
}

function chosenCurve() {
  return timeline.shown[timeline.shown.length - 1].name;
}

// The pen goes forth: a point at a time that was passed replaces what was drawn after it.
function drawPoint({ x, y }) {
  const { top, height, low, high } = timeline.area;
  const time = timeline.time(x);
  const value = (low + (1 - Math.min(Math.max((y - top) / height, 0), 1)) * (high - low)) * scaleOf(drag.channel);
  drag.points = drag.points.filter((point) => point[0] < time);
  drag.points.push([time, value]);
}

// On top of the timeline: the picked phone, closures, edges of corrected phones, and the line that is drawn.
function drawMarks(time) {
  Timeline.prototype.draw.call(timeline, time);
  const pen = timeline.canvas.getContext("2d");
  const { top, bottom } = phoneRow();
  const phone = takes[0].phones[picked];
  if (phone) {
    pen.strokeStyle = "#ffffff";
    pen.lineWidth = 1.5;
    const left = timeline.x(phone[1]);
    pen.strokeRect(left + 1, top + 1, Math.max(timeline.x(phone[2]) - left - 2, 2), bottom - top - 2);
  }
  for (const { kind, start, end } of line.settings.closures ?? line.now.closures) {
    pen.fillStyle = kind === "hold" ? "#e0604f" : "#6fb3d9";
    pen.fillRect(timeline.x(start), bottom - 3, timeline.x(end) - timeline.x(start), 3);
  }
  for (const { span } of line.settings.emotions ?? line.now.emotions) {
    if (!span) continue;
    pen.fillStyle = "#b794e0";
    pen.fillRect(timeline.x(span[0]), ROWS.ruler - 3, timeline.x(span[1]) - timeline.x(span[0]), 3);
  }
  const was = new Set(line.read.map(String));
  pen.fillStyle = "#e0c05f";
  for (const one of takes[0].phones) if (!was.has(String(one))) pen.fillRect(timeline.x(one[1]), top, timeline.x(one[2]) - timeline.x(one[1]), 2);
  if (drag?.points) drawStroke(pen);
}

function drawStroke(pen) {
  const { top, height, low, high } = timeline.area;
  pen.strokeStyle = "#ffffff";
  pen.lineWidth = 2;
  pen.beginPath();
  for (const [time, value] of drag.points) pen.lineTo(timeline.x(time), top + height * (1 - (value / scaleOf(drag.channel) - low) / (high - low)));
  pen.stroke();
}

function loopPicked() {
  const phone = takes[0].phones[picked];
  looped = phone ? [Math.max(phone[1] - 0.15, 0), Math.min(phone[2] + 0.15, duration)] : [0, duration];
}

function keepLoop() {
  if (looped && player.playing && (player.time >= looped[1] - 1e-3 || player.time < looped[0] - 0.05)) {
    seek(looped[0]);
    play();
  }
  requestAnimationFrame(keepLoop);
}

function nudge(edge, by) {
  if (picked < 0) return;
  moveEdge(picked, edge, takes[0].phones[picked][edge] + by);
  clearTimeout(nudge.waiting); // several presses are one change
  nudge.waiting = setTimeout(() => correctEdge(picked, edge), 250);
}

const ACTS = {
  "[": () => pick(picked < 0 ? phoneAt(player.time) : picked - 1), "]": () => pick(picked < 0 ? phoneAt(player.time) : picked + 1),
  ",": () => nudge(1, -STEP), ".": () => nudge(1, STEP), "<": () => nudge(2, -STEP), ">": () => nudge(2, STEP),
  e: () => picked >= 0 && bench.askLabel(), h: () => picked >= 0 && setClosure("hold", picked),
  r: () => picked >= 0 && setClosure("release", picked),
  d: () => bench.setDrawing(!drawing), D: () => timeline.shown.length && drawCurve(chosenCurve(), []),
  l: () => { looped ? (looped = null) : loopPicked(); bench.show(); },
  c: () => bench.compare(), u: undo, z: undo, s: () => bench.toggleSettings(), m: () => bench.askComment(),
  a: () => decide(line.status === "approved" ? "" : "approved"), x: () => decide(line.status === "rejected" ? "" : "rejected"),
  "?": () => bench.help(), Escape: () => bench.close(),
};
const LISTED = ["j", "k", "/", "ArrowUp", "ArrowDown"]; // keys of the list around this page

function pressKey(key) {
  const button = { " ": "play", ArrowLeft: "back", ArrowRight: "forth" }[key];
  if (button) $(button).click();
  else if (ACTS[key]) ACTS[key]();
}

function editorKeys(event) {
  const field = event.target.matches("input, select, textarea");
  if (field && event.key === "Escape") event.target.blur();
  if (field || event.altKey) return;
  if ((event.ctrlKey || event.metaKey) && event.key !== "z") return;
  if (LISTED.includes(event.key) && parent !== window) parent.postMessage({ phonanim: "key", key: event.key }, location.origin);
  else if (ACTS[event.key]) ACTS[event.key]();
  else return;
  event.preventDefault();
  event.stopImmediatePropagation();
}

$("timeline").addEventListener("pointerdown", grab, true);
$("timeline").addEventListener("pointermove", follow, true);
$("timeline").addEventListener("pointerup", letGo, true);
document.addEventListener("keydown", editorKeys, true);
window.addEventListener("message", (event) => {
  if (event.origin === location.origin && event.data.phonanim === "key") pressKey(event.data.key);
});
timeline.draw = drawMarks;
Object.assign(window.phonanim, { line, pick, pressKey, moveEdge, relabel, setClosure, correct, drawCurve });
keepLoop();
bench.show();
