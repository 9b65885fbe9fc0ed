// What is corrected in this line. Every change goes to the server at once, which keeps it and makes the line anew.

const SHORTEST = 0.005; // seconds of a phone
const line = data.review;
line.who = localStorage.getItem("phonanim-who") || line.who;
let kept = copyPhones(takes[0].phones); // as the server has them
let queue = Promise.resolve();

function copyPhones(phones) {
  return phones.map((phone) => [...phone]);
}

async function ask(path, body) {
  const headers = { "Content-Type": "application/json", "X-Phonanim-Token": line.token };
  const asked = { line: line.number, revision: line.revision, who: line.who, ...body };
  const response = await fetch(path, { method: "POST", headers, body: JSON.stringify(asked) });
  const answer = await response.json();
  if (!response.ok) throw Object.assign(new Error(answer.error), { conflict: response.status === 409 });
  return answer;
}

// One request after the other, as each needs the revision that the one before left.
function inTurn(path, what, body) {
  queue = queue.then(async () => {
    const started = performance.now();
    bench.say(`${what} …`);
    try {
      receive(await ask(path, body()));
      const done = Math.round(performance.now() - started);
      document.documentElement.dataset.made = done;
      bench.say(path === "/decide" ? what : `${what}: made in ${done} ms`);
    } catch (error) {
      takes[0].phones = copyPhones(kept);
      bench.say(error.message, error.conflict ? "conflict" : "error");
    }
    bench.show();
  });
  return queue;
}

function receive(answer) {
  Object.assign(line, answer.review);
  if (answer.take) {
    Object.assign(takes[0], readTake({ ...answer.take, name: takes[0].name, targets: takes[0].targets }));
    kept = copyPhones(takes[0].phones);
  }
  const { number, status, revision, events } = line;
  const comments = events.filter((event) => event.kind === "comment").length;
  if (parent !== window) parent.postMessage({ phonanim: "line", number, status, revision, comments }, location.origin);
}

function correct(what, change = {}) {
  const spoken = copyPhones(takes[0].phones);
  return inTurn("/correct", what, () => ({
    what, spoken, settings: line.settings, style: line.style, drawn: {}, ...change,
  }));
}

function decide(status, text = "") {
  const what = { approved: "approved", rejected: "rejected", "": "open again" }[status];
  return inTurn("/decide", what, () => ({ status, text }));
}

function comment(text) {
  return inTurn("/decide", "commented", () => ({ text }));
}

function undo() {
  return inTurn("/undo", "undone", () => ({}));
}

// Move where a phone begins (edge 1) or ends (edge 2); the phone that touches it there moves along.
function moveEdge(place, edge, time) {
  const phones = takes[0].phones;
  const phone = phones[place], other = phones[place + (edge === 1 ? -1 : 1)];
  const touches = other && Math.abs(other[3 - edge] - phone[edge]) < 1e-6;
  const low = edge === 1 ? (touches ? other[1] + SHORTEST : other ? other[2] : 0) : phone[1] + SHORTEST;
  const high = edge === 1 ? phone[2] - SHORTEST : touches ? other[2] - SHORTEST : other ? other[1] : duration;
  phone[edge] = Math.round(Math.min(Math.max(time, low), high) * 1e4) / 1e4;
  if (touches) other[3 - edge] = phone[edge];
}

// Another label; several, with spaces between, share the time; none leaves it to the phone before.
function relabel(place, text) {
  const phones = takes[0].phones;
  const [label, start, end] = phones[place];
  const labels = text.trim().split(/\s+/).filter(Boolean);
  if (text.trim() === label) return undefined;
  const share = (end - start) / Math.max(labels.length, 1);
  const found = labels.map((name, number) => [name, start + number * share, start + (number + 1) * share]);
  if (found.length) found[found.length - 1][2] = end;
  phones.splice(place, 1, ...found);
  if (!labels.length && place > 0 && Math.abs(phones[place - 1][2] - start) < 1e-6) phones[place - 1][2] = end;
  return correct(`${label || "silence"} at ${start.toFixed(2)} s is now ${labels.join(" ") || "gone"}`);
}

// Lips held together or apart during a phone; the same again gives the phone back to its rules.
function setClosure(kind, place) {
  const [label, start, end] = takes[0].phones[place];
  const all = line.settings.closures ?? line.now.closures;
  const here = all.find((one) => one.start < end && one.end > start);
  const others = all.filter((one) => one !== here);
  const closures = here?.kind === kind ? others : [...others, { kind, start, end }];
  const what = here?.kind === kind ? "lips are free" : kind === "hold" ? "lips held" : "lips apart";
  return correct(`${what} in ${label || "silence"} at ${start.toFixed(2)} s`, { settings: { ...line.settings, closures } });
}

function setSetting(name, value, what) {
  const settings = { ...line.settings };
  if (value === undefined) delete settings[name];
  else settings[name] = value;
  return correct(what || `${name} ${value ?? "as in the table"}`, { settings });
}

function setStyle(style) {
  const settings = { ...line.settings };
  for (const dial of Object.keys(line.choices.dials)) delete settings[dial];
  return correct(`style ${style || "as in the table"}`, { style, settings: { ...settings, ...line.choices.styles[style] } });
}

function drawCurve(channel, points) {
  const what = points.length ? `drew ${channel} from ${points[0][0].toFixed(2)} s` : `cleared what was drawn over ${channel}`;
  return correct(what, { drawn: { [channel]: points } });
}
