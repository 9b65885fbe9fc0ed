"use strict";
// The list of a review. Only the rows that are seen are in the document, so that it stays small.
const data = JSON.parse(document.getElementById("data").textContent);
const [list, room, search, count, what, player] = ["list", "room", "search", "count", "what", "player"].map((id) =>
  document.getElementById(id),
);
const ROW = 44; // pixels, as in the style sheet
const CHOICES = { status: (line) => [line.status], check: (line) => line.checks,
  language: (line) => [line.language], rig: (line) => [line.rig] };
const lines = data.lines.map((line, number) => ({
  ...line, number, words: `${line.id} ${line.place} ${line.text} ${line.language} ${line.rig}`.toLowerCase(),
}));
let shown = lines, chosen = 0, playing = -1;

function fillChoices() {
  for (const [id, values] of Object.entries(CHOICES)) {
    const counts = new Map();
    for (const line of lines) for (const value of values(line)) if (value) counts.set(value, (counts.get(value) || 0) + 1);
    const select = document.getElementById(id);
    select.hidden = counts.size < 2 && id !== "check";
    const names = id === "status" ? ["failed", "flagged", "good"].filter((name) => counts.has(name)) : [...counts.keys()].sort();
    select.append(new Option(`any ${id === "check" ? "flag" : id}`, ""));
    for (const name of names) select.append(new Option(`${name} (${counts.get(name)})`, name));
    select.addEventListener("change", filterLines);
  }
}

function filterLines() {
  const asked = search.value.toLowerCase().split(/\s+/).filter(Boolean);
  const wanted = Object.entries(CHOICES).map(([id, values]) => [document.getElementById(id).value, values]).filter(([value]) => value);
  shown = lines.filter((line) => asked.every((word) => line.words.includes(word))
    && wanted.every(([value, values]) => values(line).includes(value)));
  chosen = 0;
  list.scrollTop = 0;
  count.textContent = `${shown.length} of ${lines.length}`;
  drawRows();
}

function drawRows() {
  const first = Math.max(0, Math.floor(list.scrollTop / ROW) - 5);
  const last = Math.min(shown.length, first + Math.ceil(list.clientHeight / ROW) + 10);
  room.style.height = `${shown.length * ROW}px`;
  room.replaceChildren(...shown.slice(first, last).map((line, offset) => drawRow(line, first + offset)));
}

function drawRow(line, place) {
  const row = document.createElement("div");
  row.className = `line ${line.status}`;
  row.id = `line${line.number}`;
  row.setAttribute("role", "option");
  row.setAttribute("aria-selected", String(place === chosen));
  row.style.top = `${place * ROW}px`;
  const name = document.createElement("b"), about = document.createElement("small");
  name.textContent = line.id;
  about.textContent = [line.seconds ? `${line.seconds.toFixed(1)} s` : "", line.language, line.text].filter(Boolean).join(" · ");
  row.append(name, about);
  row.addEventListener("click", () => { choose(place); play(); });
  return row;
}

function choose(place) {
  chosen = Math.min(Math.max(place, 0), shown.length - 1);
  const top = chosen * ROW;
  if (top < list.scrollTop) list.scrollTop = top;
  if (top + ROW > list.scrollTop + list.clientHeight) list.scrollTop = top + ROW - list.clientHeight;
  drawRows();
  const line = shown[chosen];
  if (line) list.setAttribute("aria-activedescendant", `line${line.number}`);
}

function play() {
  const line = shown[chosen];
  if (!line) return;
  what.textContent = [`${line.id} (${line.place})`, line.text].filter(Boolean).join(" · ");
  if (playing !== line.number) player.src = `/line?n=${line.number}&token=${encodeURIComponent(data.token)}`;
  playing = line.number;
}

function press(id) {
  const page = player.contentDocument;
  const button = page && page.getElementById(id);
  if (button) button.click();
}

const KEYS = {
  " ": () => press("play"), ArrowLeft: () => press("back"), ArrowRight: () => press("forth"),
  j: () => choose(chosen + 1), ArrowDown: () => choose(chosen + 1),
  k: () => choose(chosen - 1), ArrowUp: () => choose(chosen - 1),
  PageDown: () => choose(chosen + 10), PageUp: () => choose(chosen - 10),
  Home: () => choose(0), End: () => choose(shown.length - 1),
  Enter: play, "/": () => search.focus(),
};
document.addEventListener("keydown", (event) => {
  if (event.target === search) {
    if (event.key === "Enter" || event.key === "Escape") list.focus();
    return;
  }
  if (event.target.tagName === "SELECT" || event.ctrlKey || event.metaKey || event.altKey || !KEYS[event.key]) return;
  event.preventDefault();
  KEYS[event.key]();
});
search.addEventListener("input", filterLines);
list.addEventListener("scroll", drawRows);
window.addEventListener("resize", drawRows);
fillChoices();
filterLines();
list.focus();
