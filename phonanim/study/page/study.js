const study = JSON.parse(document.getElementById("data").textContent);
const $ = (id) => document.getElementById(id);
const STARS = ["Does not match", "Barely matches", "Somewhat matches", "Matches", "Perfectly matches"];
const THIRD = { none: "Neither fits", equal: "Both alike" }[study.choices];
const KEYS = {
  " ": "both", q: "play-left", w: "play-right",
  ArrowLeft: "choose-left", ArrowRight: "choose-right", ArrowDown: "choose-third",
  1: "star-1", 2: "star-2", 3: "star-3", 4: "star-4", 5: "star-5",
};
const player = new Player({ left: $("left"), right: $("right") }, study.films, refresh, filmFailed);
let state = load();
let answer = {};
let asked = 0; // which of the questions is asked about the pair
let shownAt = 0;
let broken = false;

// What is kept between visits, by study and participant; null where the browser keeps nothing.
function storage() {
  try {
    return window.localStorage;
  } catch {
    return null;
  }
}

function load() {
  const named = new URLSearchParams(location.search).get("participant");
  const participant = named || storage()?.getItem(`phonanim ${study.id}`) || newName();
  const kept = storage()?.getItem(`phonanim ${study.id} ${participant}`);
  if (kept) return JSON.parse(kept);
  const seed = seedOf(`${study.id} ${participant}`);
  const order = orderFor(study.trials, study.limit, seed);
  return { participant, seed, order, answers: [], started: null, ended: null };
}

// Twelve letters and digits; crypto.randomUUID is missing on pages that come over plain http.
function newName() {
  return [...crypto.getRandomValues(new Uint8Array(6))].map((byte) => byte.toString(16).padStart(2, "0")).join("");
}

function save() {
  storage()?.setItem(`phonanim ${study.id}`, state.participant);
  storage()?.setItem(`phonanim ${study.id} ${state.participant}`, JSON.stringify(state));
}

function show(section) {
  for (const id of ["welcome", "trial", "done"]) $(id).hidden = id !== section;
  $("progress").hidden = section === "welcome";
}

function welcome() {
  $("count").textContent = state.order.length;
  $("third-told").textContent = THIRD ? `, or “${THIRD.toLowerCase()}”` : ", even where it is hard to say";
  $("rating-told").hidden = !study.rating;
  $("control-told").hidden = !(study.rating && study.choices === "none");
  $("unsaved").hidden = Boolean(storage());
  if (state.answers.length) $("start").firstChild.textContent = "Go on ";
  show("welcome");
  $("start").focus();
}

function start() {
  state.started ||= new Date().toISOString();
  step();
}

function step() {
  save();
  if (state.answers.length === state.order.length) return finish();
  const { trial, swapped } = state.order[state.answers.length];
  const [left, right] = swapped ? study.trials[trial].takes.toReversed() : study.trials[trial].takes;
  player.show({ left, right });
  answer = { choice: null, rating: null, choices: [] };
  asked = 0;
  broken = false;
  shownAt = performance.now();
  const done = state.answers.length;
  document.querySelector("#progress progress").value = done / state.order.length;
  const practice = study.trials[trial].kind === "practice" ? ", for practice" : "";
  document.querySelector("#progress span").textContent = `${done + 1} of ${state.order.length}${practice}`;
  show("trial");
  refresh();
  $("both").focus();
}

function seen() {
  return player.plays.left > 0 && player.plays.right > 0;
}

// Stars are given once for a pair, with its first question.
function rated() {
  return !study.rating || asked > 0;
}

function complete() {
  return seen() && answer.choice && (answer.rating || rated());
}

function refresh() {
  const { questions } = study;
  const number = questions.length > 1 ? `${asked + 1}/${questions.length}: ` : "";
  $("question").textContent = number + questions[asked];
  for (const choice of ["left", "right", "third"]) {
    const button = $(`choose-${choice}`);
    button.disabled = !seen();
    button.setAttribute("aria-pressed", String(answer.choice === (choice === "third" ? study.choices : choice)));
  }
  $("rating").hidden = rated();
  const one = answer.choice === "left" || answer.choice === "right";
  $("rating-asked").textContent = one ? "How well does the film that you chose match the speech?"
    : "How well do the face and the speech match?";
  for (let star = 1; star <= 5; star++) {
    const button = $(`star-${star}`);
    button.disabled = !seen() || !answer.choice;
    button.textContent = star <= answer.rating ? "★" : "☆";
    button.setAttribute("aria-pressed", String(star === answer.rating));
  }
  $("star-said").textContent = answer.rating ? STARS[answer.rating - 1] : "";
  $("next").disabled = !complete();
  $("hint").classList.toggle("warning", broken);
  if (!broken) $("hint").textContent = seen() ? "" : "Watch both films to their end.";
}

function filmFailed(side) {
  broken = true;
  refresh();
  $("hint").textContent = `The ${side} film cannot be played here. Please open this page in another browser.`;
}

function choose(choice) {
  answer.choice = choice;
  refresh();
}

function rate(stars) {
  answer.rating = stars;
  refresh();
}

function next() {
  if (!complete()) return;
  answer.choices.push(answer.choice);
  if (answer.choices.length < study.questions.length) {
    asked += 1;
    answer.choice = null;
    refresh();
    return $("both").focus();
  }
  player.stop();
  const { trial, swapped } = state.order[state.answers.length];
  const { item, kind, takes, expected } = study.trials[trial];
  const [left, right] = (swapped ? takes.toReversed() : takes).map((take) => take.system);
  const side = (take) => ((take === 0) !== swapped ? "left" : "right");
  state.answers.push({
    item, kind, left, right, ...answer, choice: answer.choices[0],
    expected: typeof expected === "number" ? side(expected) : expected,
    plays: { ...player.plays },
    seconds: Math.round((performance.now() - shownAt) / 100) / 10,
  });
  step();
}

function result() {
  return {
    format: "phonanim study result 1",
    study: study.id, title: study.title, choices: study.choices, rating: study.rating,
    questions: study.questions,
    participant: state.participant, seed: state.seed, started: state.started, ended: state.ended,
    answers: state.answers,
  };
}

function finish() {
  const first = !state.ended;
  state.ended ||= new Date().toISOString();
  save();
  document.querySelector("#progress progress").value = 1;
  document.querySelector("#progress span").textContent = `${state.answers.length} of ${state.order.length}`;
  $("thanks").textContent = study.thanks;
  const text = JSON.stringify(result(), null, 1);
  $("download").href = URL.createObjectURL(new Blob([text], { type: "application/json" }));
  $("download").download = `${study.id}-${state.participant.replace(/[^\w-]/g, "_")}.json`;
  $("posted").textContent = study.post ? "" : "Please download your answers and send them to those who asked you.";
  show("done");
  $("download").focus();
  if (study.post && (first || !state.posted)) post(text);
}

// Sent as plain text: a page opened from disk may post that anywhere, without asking the server first.
async function post(text) {
  $("posted").textContent = "Sending your answers …";
  try {
    const reply = await fetch(study.post, { method: "POST", body: text });
    if (!reply.ok) throw new Error(`the server says ${reply.status}`);
    state.posted = true;
    save();
    $("posted").textContent = "Your answers have been received. There is nothing more to do.";
  } catch (error) {
    $("posted").textContent =
      `Your answers could not be sent (${error.message}). Please download them and send them by mail, ` +
      "or load this page again to have them sent once more.";
  }
}

function build() {
  for (let star = 1; star <= 5; star++) {
    const button = document.createElement("button");
    Object.assign(button, { id: `star-${star}`, className: "star", title: `${STARS[star - 1]}: key ${star}` });
    button.setAttribute("aria-label", `${star} of 5: ${STARS[star - 1]}`);
    button.addEventListener("click", () => rate(star));
    $("stars").append(button);
  }
  $("choose-third").hidden = !THIRD;
  document.querySelector("#choose-third span").textContent = THIRD || "";
  const clicks = {
    start, next,
    both: () => player.play("left", "right"),
    "play-left": () => player.play("left"),
    "play-right": () => player.play("right"),
    "choose-left": () => choose("left"),
    "choose-right": () => choose("right"),
    "choose-third": () => choose(study.choices),
  };
  for (const [id, click] of Object.entries(clicks)) $(id).addEventListener("click", click);
}

function enter() {
  if (!$("welcome").hidden) $("start").click();
  else if (!$("trial").hidden) $("next").click();
}

document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.altKey || event.metaKey || event.repeat) return;
  if (event.key === "Enter" && event.target.id !== "download") {
    // A choice or a play button that has the focus is pressed by Enter, as everywhere.
    if (event.target.tagName === "BUTTON" && !complete()) return;
    event.preventDefault();
    return enter();
  }
  const button = $(KEYS[event.key] || KEYS[event.key.toLowerCase()]);
  if (!button || button.hidden || button.disabled || $("trial").hidden) return;
  event.preventDefault();
  button.click();
});

// Without this the button that has the focus would be pressed too when the key comes up.
document.addEventListener("keyup", (event) => {
  if (event.key === " " && !$("trial").hidden) event.preventDefault();
});

build();
if (state.ended) finish();
else welcome();
