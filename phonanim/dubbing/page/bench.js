// What stands around the timeline: buttons, the settings of the line, its history, and what was said last.

function make(tag, fields = {}, ...children) {
  const element = Object.assign(document.createElement(tag), fields);
  element.append(...children);
  return element;
}

function buildBench() {
  const button = (key, name, title) => {
    const element = make("button", { textContent: name, title: `${title} (${key})` });
    element.dataset.key = key;
    element.addEventListener("click", () => pressKey(key));
    return element;
  };
  const buttons = [
    button("a", "Approve", "Approve, or take it back"), button("x", "Reject", "Reject, or take it back"),
    button("m", "Comment", "Say something"), button("u", "Undo", "Take back the last correction or decision"),
    button("[", "‹", "Phone before"), button("]", "›", "Next phone"), button("e", "Phone", "Change the label of the phone"),
    button("h", "Hold", "Hold the lips closed in the phone"), button("r", "Release", "Keep the lips apart in the phone"),
    button("d", "Draw", "Draw over the curve that was chosen last"), button("l", "Loop", "Repeat the phone"),
    button("c", "Compare", "Beside the take that was delivered"), button("s", "Settings", "Style, language, emotions, gains"),
    button("?", "Keys", "All keys"),
  ];
  const said = make("output", { id: "said" });
  const panel = make("aside", { id: "settings", hidden: true, tabIndex: -1, ariaLabel: "Settings of the line" });
  const bar = make("section", { id: "bench" }, ...buttons, said);
  document.querySelector("nav").after(bar);
  document.body.append(panel);
  const self = {
    say(text, kind = "") {
      said.textContent = text;
      said.className = kind;
      if (kind === "conflict") said.append(" ", make("button", { textContent: "Load it", onclick: () => location.reload() }));
    },
    show() {
      const pressed = { a: line.status === "approved", x: line.status === "rejected", d: drawing, l: looped, c: line.compare, s: !panel.hidden };
      for (const element of buttons) if (element.dataset.key in pressed) element.setAttribute("aria-pressed", String(Boolean(pressed[element.dataset.key])));
      document.documentElement.dataset.revision = line.revision;
      document.documentElement.dataset.status = line.status;
      if (!panel.hidden) panel.replaceChildren(...settingsOf(self));
    },
    setDrawing(on) {
      drawing = on;
      self.say(on ? `draw over ${timeline.shown.length ? chosenCurve() : "a curve: choose one"}; D clears it` : "");
      self.show();
    },
    toggleSettings() {
      panel.hidden = !panel.hidden;
      self.show();
      if (!panel.hidden) panel.focus(); // Tab goes to the first field
    },
    compare() {
      const address = new URL(location.href);
      line.compare ? address.searchParams.delete("compare") : address.searchParams.set("compare", "1");
      location.replace(address);
    },
    close() {
      if (!panel.hidden) self.toggleSettings();
      else if (drawing) self.setDrawing(false);
      else if (parent !== window) parent.postMessage({ phonanim: "key", key: "Escape" }, location.origin);
    },
    askComment: () => askText("Comment", "", (text) => comment(text)),
    askLabel: () => askText("Phone (several share its time, none removes it)", takes[0].phones[picked][0], (text) => relabel(picked, text)),
    help: () => self.say("[ ] phone · , . start · < > end · e label · h hold · r release · d draw · D clear · l loop · c compare · s settings · a approve · x reject · m comment · u undo · space play · ← → frame · j k line"),
  };
  if (line.notes.length) self.say(line.notes.join("; "));
  return self;
}

function askText(title, text, done) {
  const field = make("input", { value: text, ariaLabel: title });
  const dialog = make("dialog", {}, make("form", { method: "dialog" }, make("label", {}, title, field)));
  field.addEventListener("keydown", (event) => {
    event.stopPropagation();
    if (event.key === "Escape") dialog.remove();
    if (event.key !== "Enter") return;
    event.preventDefault();
    dialog.remove();
    done(field.value);
  });
  document.body.append(dialog);
  dialog.showModal();
  field.select();
}

// The panel: made anew from what the server says after every change.
function settingsOf() {
  const { choices, settings, now } = line;
  return [
    row("You are", make("input", { value: line.who, onchange: (event) => {
      line.who = event.target.value;
      localStorage.setItem("phonanim-who", line.who);
    } })),
    row("Style", choose(["", ...Object.keys(choices.styles)], line.style, setStyle)),
    row("Language", choose(["", ...choices.languages], settings.language ?? "", (name) => setSetting("language", name || undefined), now.language)),
    row("Loudness", number(settings.loudness ?? now.loudness, 0, 4, (value) => setSetting("loudness", value))),
    ...Object.entries(choices.dials).map(([dial, [low, high]]) =>
      row(dial, number(settings[dial] ?? now[dial], low, high, (value) => setSetting(dial, value)))),
    make("h2", { textContent: "Emotions" }), ...emotionRows(settings.emotions ?? now.emotions),
    make("h2", { textContent: "Gains of controls" }), ...gainRows(settings.gains ?? {}),
    ...(line.drawn.length ? [make("h2", { textContent: "Drawn curves" }), ...line.drawn.map((name) => row(name, remove(() => drawCurve(name, []))))] : []),
    ...(line.notes.length ? [make("h2", { textContent: "Notes" }), ...line.notes.map((note) => make("p", { textContent: note }))] : []),
    make("h2", { textContent: "What was done" }),
    ...line.events.map(({ at, who, kind, text, undone }) =>
      make("p", { className: undone ? "undone" : "", textContent: `${at.replace("T", " ").replace("Z", "")} ${who}: ${kind}${text ? ` · ${text}` : ""}` })),
  ];
}

function row(name, ...fields) {
  return make("label", {}, make("span", { textContent: name }), ...fields);
}

function choose(names, chosen, changed, empty = "as in the table") {
  const select = make("select", { onchange: () => changed(select.value) }, ...names.map((name) => new Option(name || `(${empty})`, name)));
  select.value = chosen;
  return select;
}

function number(value, low, high, changed) {
  const field = make("input", { type: "number", min: low, max: high, step: 0.05, value });
  field.addEventListener("change", () => field.reportValidity() && changed(Number(field.value)));
  return field;
}

function remove(done) {
  return make("button", { textContent: "✕", title: "Remove", onclick: done });
}

function emotionRows(emotions) {
  const set = (list) => setSetting("emotions", list, "emotions");
  const change = (place, part) => set(emotions.map((one, other) => (other === place ? { ...one, ...part } : one)));
  const span = () => (picked >= 0 ? takes[0].phones[picked].slice(1) : [player.time, Math.min(player.time + 1, duration)]);
  return [
    ...emotions.map((one, place) => row(
      "", choose(line.choices.emotions, one.name, (name) => change(place, { name })),
      number(one.weight, 0, 4, (weight) => change(place, { weight })),
      number(one.span?.[0] ?? 0, 0, duration, (start) => change(place, { span: [start, one.span?.[1] ?? duration] })),
      number(one.span?.[1] ?? duration, 0, duration, (end) => change(place, { span: [one.span?.[0] ?? 0, end] })),
      remove(() => set(emotions.filter((_, other) => other !== place))),
    )),
    make("button", { textContent: "Add an emotion here", onclick: () => set([...emotions, { name: line.choices.emotions[0], weight: 0.5, span: span() }]) }),
  ];
}

function gainRows(gains) {
  const set = (found) => setSetting("gains", found, "gains");
  const without = (name) => Object.fromEntries(Object.entries(gains).filter(([key]) => key !== name));
  const names = line.controls.filter((name) => !(name in gains));
  return [
    ...Object.entries(gains).map(([name, gain]) => row(
      name, number(gain, 0, 4, (value) => set({ ...gains, [name]: value })), remove(() => set(without(name))),
    )),
    row("Add", choose(["", ...names], "", (name) => name && set({ ...gains, [name]: 1 }), "a control")),
  ];
}
