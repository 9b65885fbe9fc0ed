// The live page: frames come in over a socket, and the head shows the last one.

const $ = (id) => document.getElementById(id);
const data = JSON.parse($("data").textContent);
const values = new Float32Array(data.channels.length);
const take = { channels: data.channels, targets: data.targets, at: (channel) => values[channel] };
const stage = new Stage($("stage"), [take]);
const bars = data.channels.map(bar);
const AGAIN = 1000; // milliseconds until a lost stream is looked for again
const HEAD = 16; // bytes before the values: frame number (uint32), 4 of padding, seconds (float64)
const MOVED = 0.01;
const LOST = 500; // milliseconds without a frame, after which the face goes back to rest
const EASE = 90; // milliseconds in which it covers most of the way
const APART = 0.08; // seconds that the sound may be away from the frames
const come = []; // when the frames of the last second came
const sound = data.audio ? new Audio(data.audio) : null;
let last = null, since = -Infinity, before = performance.now(), socket = null;

function bar(name) {
  const row = document.createElement("div");
  row.className = "curve";
  row.innerHTML = "<b></b><output></output><u></u>";
  row.hidden = true; // until it moves
  row.children[0].textContent = row.title = name;
  $("curves").append(row);
  return row;
}

function listen() {
  socket = new WebSocket(`ws://${location.host}/live`);
  socket.binaryType = "arraybuffer";
  socket.onopen = () => {
    told("live", true);
    if (!sound || $("begin").hidden) socket.send("ready");
  };
  socket.onmessage = ({ data: packet }) => { if (packet instanceof ArrayBuffer) receive(packet); };
  socket.onclose = () => {
    if (sound) sound.pause();
    told("the stream has ended; waiting for another", false);
    setTimeout(listen, AGAIN);
  };
}

function told(text, live) {
  $("state").value = text;
  $("state").dataset.live = live;
}

function receive(packet) {
  const view = new DataView(packet);
  last = { frame: view.getUint32(0, true), time: view.getFloat64(8, true) };
  values.set(new Float32Array(packet, HEAD));
  since = performance.now();
  come.push(since);
  if (sound && $("begin").hidden) keepInStep(data.start + last.time);
}

// A browser plays sound only after a click, so the page asks for one, and the stream may wait for it.
async function begin() {
  $("begin").hidden = true;
  await sound.play().catch(() => told("the browser does not play the sound", true));
  if (!last) sound.pause();
  if (socket?.readyState === WebSocket.OPEN) socket.send("ready");
}

function keepInStep(time) {
  if (time >= sound.duration) return;
  if (Math.abs(sound.currentTime - time) > APART) sound.currentTime = time;
  if (sound.paused) sound.play().catch(() => {});
}

// When frames stop coming, nobody stays with an open mouth.
function goToRest(passed) {
  if (sound && !sound.paused) sound.pause();
  const share = 1 - Math.exp(-passed / EASE);
  for (let i = 0; i < values.length; i++) values[i] += (data.rest[i] - values[i]) * share;
}

function tick(now) {
  if (now - since > LOST) goToRest(now - before);
  before = now;
  while (come.length && come[0] < now - 1000) come.shift();
  stage.draw(0);
  if (last) {
    $("clock").value = `${last.time.toFixed(2)} s`;
    $("rate").value = `${come.length} frames a second`;
    document.documentElement.dataset.frame = last.frame;
  }
  bars.forEach((row, channel) => {
    row.hidden &&= Math.abs(values[channel]) < MOVED;
    row.children[1].value = values[channel].toFixed(2);
    row.children[2].style.width = `${Math.min(Math.abs(values[channel]), 1) * 95}%`;
  });
  requestAnimationFrame(tick);
}

$("facts").textContent = data.facts;
values.set(data.rest);
$("begin").hidden = !sound;
$("begin").addEventListener("click", begin);
document.addEventListener("keydown", (event) => event.key === " " && !$("begin").hidden && begin());
stage.load(bytesOf(data.head)).then(() => {
  listen();
  requestAnimationFrame(tick);
});
