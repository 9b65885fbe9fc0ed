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
const come = []; // when the frames of the last second came
let last = null;

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
  const socket = new WebSocket(`ws://${location.host}/live`);
  socket.binaryType = "arraybuffer";
  socket.onopen = () => told("live", true);
  socket.onmessage = ({ data: packet }) => { if (packet instanceof ArrayBuffer) receive(packet); };
  socket.onclose = () => {
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
  come.push(performance.now());
}

function tick(now) {
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
stage.load(bytesOf(data.head)).then(() => {
  listen();
  requestAnimationFrame(tick);
});
