// The page: one time for the heads, the sound, the timeline and the list of curves.

// Turns of the head are in degrees, all other controls from 0 to 1.
const TURNS = ["headPitch", "headYaw", "headRoll"];
const FULL_TURN = 45; // degrees that count as much as a control's full weight

const $ = (id) => document.getElementById(id);
const data = JSON.parse($("data").textContent);
const takes = data.takes.map(readTake);
const duration = Math.max(...takes.map((take) => take.end), ...takes.flatMap((take) => take.phones.map((p) => p[2])));
const sound = data.audio ? new Audio(data.audio) : null;
const player = { time: 0, playing: false, until: Infinity, seek, play, pause };
const timeline = new Timeline($("timeline"), takes, duration, (time) => { seek(time); });
const stage = new Stage($("stage"), takes);
const rows = listCurves();
let before = performance.now();

function seek(time) {
  player.time = Math.min(Math.max(time, 0), duration);
  player.until = Infinity;
  if (sound) sound.currentTime = player.time;
}

function play(until = Infinity) {
  if (player.time >= duration - 1e-3) seek(0);
  player.playing = true;
  player.until = until;
  $("play").textContent = "Pause";
  if (sound && player.time < sound.duration) sound.play();
}

function pause() {
  player.playing = false;
  $("play").textContent = "Play";
  if (sound) sound.pause();
}

// The sound is the clock while it plays; before and after it, the page's own.
function advance(now) {
  const passed = ((now - before) / 1000) * Number($("speed").value);
  before = now;
  if (!player.playing) return;
  player.time += passed;
  if (sound && !sound.paused && Math.abs(sound.currentTime - player.time) > 0.03) player.time = sound.currentTime;
  const end = Math.min(duration, player.until);
  if (player.time < end) return;
  const again = $("loop").checked && player.until === Infinity;
  if (!again) pause();
  seek(again ? 0 : end);
  if (again) play();
}

function tick(now) {
  advance(now);
  if (player.playing) timeline.follow(player.time);
  stage.draw(player.time);
  timeline.draw(player.time);
  const words = intervalAt(takes[0].words, player.time), phone = intervalAt(takes[0].phones, player.time);
  $("clock").value = `${player.time.toFixed(3)} s`;
  $("now").value = [words, phone].filter(Boolean).map(([label]) => label).filter(Boolean).join(" · ");
  for (const row of rows) row.show(player.time);
  document.documentElement.dataset.drawn = player.time.toFixed(3);
  requestAnimationFrame(tick);
}

// A row per channel, the one that moves most first, millimetres last; the first three are chosen.
function listCurves() {
  const names = [...new Set(takes.flatMap((take) => take.channels))];
  const motion = (name) => Math.max(...takes.map((take) => {
    const range = take.range[take.channels.indexOf(name)];
    const scale = TURNS.includes(name) ? FULL_TURN : scaleOf(name);
    return range ? (range[1] - range[0]) / scale : 0;
  })) - (scaleOf(name) > 1 ? 1000 : 0); // millimetres after the controls
  // Jaw and lips first, as they are what a line is looked at for; then what moves most.
  const rank = (name) => motion(name) + (/^(jaw|mouth)/i.test(name) && motion(name) > 0 ? 10 : 0);
  names.sort((a, b) => rank(b) - rank(a));
  return names.map((name, place) => curveRow(name, place < 3 && motion(name) > 0));
}

function curveRow(name, chosen) {
  const row = document.createElement("button");
  row.className = "curve";
  row.innerHTML = "<i></i><b></b><output></output><u></u>";
  const [chip, label, value, bar] = row.children;
  label.textContent = label.title = name;
  const choose = (on) => {
    row.setAttribute("aria-pressed", on);
    timeline.shown = timeline.shown.filter((shown) => shown.name !== name);
    const free = COLORS.find((color) => !timeline.shown.some((shown) => shown.color === color)) || COLORS[0];
    chip.style.background = on ? free : "";
    if (on) timeline.shown.push({ name, color: free });
  };
  choose(chosen);
  row.addEventListener("click", () => choose(row.getAttribute("aria-pressed") !== "true"));
  $("curves").append(row);
  const show = (time) => {
    const values = takes.map((take) => [take, take.channels.indexOf(name)]).filter(([, channel]) => channel >= 0)
      .map(([take, channel]) => take.at(channel, time));
    value.value = values[0].toFixed(3);
    bar.style.width = `${Math.min(Math.abs(values[0]) / scaleOf(name), 1) * 85}%`;
  };
  return { name, row, show };
}

function playPhone(event) {
  const span = intervalAt(takes[0].phones, timeline.timeOf(event));
  if (!span) return;
  seek(span[1]);
  play(span[2]);
}

function keys(event) {
  if (event.target.matches("input, select")) return;
  const frame = 1 / takes[0].fps;
  const moves = { ArrowLeft: -frame, ArrowRight: frame, Home: -Infinity, End: Infinity };
  if (event.key === " ") player.playing ? pause() : play();
  else if (event.key in moves) seek(Math.min(Math.max(player.time + moves[event.key], 0), duration));
  else return;
  event.preventDefault();
}

// "#t=1.25" opens the page at that time.
function fromAddress() {
  const found = /t=([\d.]+)/.exec(location.hash);
  if (found) seek(Number(found[1]));
}

async function drawSound() {
  const context = new OfflineAudioContext(1, 1, 16000);
  const decoded = await context.decodeAudioData(bytesOf(data.audio.split(",")[1]).buffer);
  const samples = decoded.getChannelData(0);
  const peak = samples.reduce((most, sample) => Math.max(most, Math.abs(sample)), 1e-6);
  timeline.wave = { samples: samples.map((sample) => sample / peak), rate: decoded.sampleRate };
}

$("facts").textContent = data.facts;
$("play").addEventListener("click", () => (player.playing ? pause() : play()));
$("back").addEventListener("click", () => seek(player.time - 1 / takes[0].fps));
$("forth").addEventListener("click", () => seek(player.time + 1 / takes[0].fps));
$("speed").addEventListener("change", () => { if (sound) sound.playbackRate = Number($("speed").value); });
$("search").addEventListener("input", () => {
  const wanted = $("search").value.toLowerCase();
  for (const { name, row } of rows) row.hidden = !name.toLowerCase().includes(wanted);
});
$("labels").innerHTML = takes.length > 1 ? takes.map((_, i) => `<span style="left:${((i + 0.5) / takes.length) * 100}%"></span>`).join("") : "";
[...$("labels").children].forEach((label, i) => { label.textContent = takes[i].name + (i ? " (broken lines)" : ""); });
$("timeline").addEventListener("dblclick", playPhone);
document.addEventListener("keydown", keys);
window.addEventListener("hashchange", fromAddress);
window.phonanim = { player, takes, stage, timeline };
fromAddress();
if (sound) drawSound();
stage.load(bytesOf(data.head || window.phonanimHead)).then(() => requestAnimationFrame(tick));
