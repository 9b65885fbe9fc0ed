"use strict";
// The list of a review. Only the rows that are seen are in the document, so that it stays small.
const data = JSON.parse(document.getElementById("data").textContent);
const [list, room, search, count, what, player] = ["list", "room", "search", "count", "what", "player"].map((id) =>
  document.getElementById(id),
);
const ROW = 44; // pixels, as in the style sheet
const OWN = ["failed", "flagged", "good"], DECIDED = ["approved", "rejected", "commented", "undecided"];
const CHOICES = { decision: (line) => [line.decision || "undecided", line.comments ? "commented" : ""], status: (line) => [line.status], check: (line) => line.checks,
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
    select.hidden = counts.size < 2 && id !== "check" && id !== "decision";
    const names = id === "decision" ? DECIDED : id === "status" ? OWN.filter((name) => counts.has(name)) : [...counts.keys()].sort();
    const chosen = select.value;
    select.replaceChildren(new Option(`any ${id === "check" ? "flag" : id}`, ""));
    for (const name of names) select.append(new Option(`${name} (${counts.get(name) || 0})`, name));
    select.value = chosen;
    select.onchange = filterLines;
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
  row.className = `line ${line.status} ${line.decision}`;
  row.id = `line${line.number}`;
  row.setAttribute("role", "option");
  row.setAttribute("aria-selected", String(place === chosen));
  row.style.top = `${place * ROW}px`;
  const name = document.createElement("b"), about = document.createElement("small");
  name.textContent = line.id;
  const said = line.comments ? `${line.comments} comment${line.comments > 1 ? "s" : ""}` : "";
  about.textContent = [line.decision, said, line.seconds ? `${line.seconds.toFixed(1)} s` : "", line.language, line.text].filter(Boolean).join(" · ");
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
  what.textContent = [`${line.id} (${line.place})`, line.said, line.text].filter(Boolean).join(" · ");
  if (playing !== line.number) player.src = data.fixed ? `lines/${line.number}.html` : `/line?n=${line.number}&token=${encodeURIComponent(data.token)}`;
  playing = line.number;
}

// What is said of a line by its page, or by others who review the same run.
function updateLine(line, { status, revision, comments }) {
  if (revision < line.revision) return;
  Object.assign(line, { decision: status, revision, comments });
  fillChoices();
  drawRows();
}

async function askNews() {
  try {
    const news = await (await fetch(`/news?after=${data.last}&token=${encodeURIComponent(data.token)}`)).json();
    data.last = news.last;
    for (const line of lines) if (news.states[line.id]) updateLine(line, news.states[line.id]);
  } catch { /* the server has ended; the next time will tell */ }
}

window.addEventListener("message", ({ origin, source, data: said }) => {
  if (origin !== location.origin || source !== player.contentWindow) return;
  if (said.phonanim === "line") updateLine(lines[said.number], said);
  if (said.phonanim === "key") {
    list.focus();
    if (!KEYS[said.key]) return;
    KEYS[said.key]();
    if (said.key !== "/") play();
  }
});

// Keys that are not of the list go to the page of the line.
function press(key) {
  const id = { " ": "play", ArrowLeft: "back", ArrowRight: "forth" }[key];
  const button = id && player.contentDocument?.getElementById(id);
  if (button) return button.click();
  player.contentWindow?.postMessage({ phonanim: "key", key }, data.fixed ? "*" : location.origin);
}

const KEYS = {
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
  if (event.target.tagName === "SELECT" || event.ctrlKey || event.metaKey || event.altKey || event.key.length > 1 && !KEYS[event.key] && !event.key.startsWith("Arrow")) return;
  event.preventDefault();
  KEYS[event.key] ? KEYS[event.key]() : press(event.key);
});
search.addEventListener("input", filterLines);
list.addEventListener("scroll", drawRows);
window.addEventListener("resize", drawRows);
fillChoices();
filterLines();
list.focus();
const csv = document.getElementById("csv");
csv.href = data.fixed ? "review.csv" : `/list.csv?token=${encodeURIComponent(data.token)}`;
if (!data.fixed) setInterval(askNews, 3000);
