// Play phonanim's `track.json` on any three.js object with morph targets, or on the expressions of a VRM.
//
//     const face = new LinePlayer(gltf.scene);
//     face.play(await loadTrack("line.track.json"), { audio: new Audio("line.wav") });
//     // in each frame: face.update(secondsSinceTheLastFrame);
//     face.stop(); // interrupts the line: back to rest within 200 ms
//
// There is no dependency and no build step. The object only needs three's `traverse`, `morphTargetDictionary`
// and `morphTargetInfluences`.

const SIDES = { l: "left", r: "right" };
const TURNS = ["headPitch", "headYaw", "headRoll"]; // degrees

// The keys of each channel: `times` in seconds and `values`, straight between. Throws for another format.
export function parseTrack(tree) {
  if (tree?.format !== "openfacefx.track" || tree.version !== 1) {
    throw new Error(`not an OpenFaceFX track of version 1: ${tree?.format} ${tree?.version}`);
  }
  const channels = tree.channels.map(({ name, keys }) => ({
    name,
    times: keys.map(([time]) => time),
    values: keys.map(([, value]) => value),
  }));
  return { duration: tree.duration, channels };
}

// Fetch a track. Throws when it cannot be had or is another format.
export async function loadTrack(url) {
  const response = await fetch(url);
  if (!response.ok) throw new Error(`${url}: ${response.status} ${response.statusText}`);
  return parseTrack(await response.json());
}

// The value of a channel at a time; end values are held.
export function valueAt({ times, values }, time) {
  let low = 0, high = times.length - 1;
  if (high < 0) return 0;
  if (time <= times[0]) return values[0];
  if (time >= times[high]) return values[high];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time) low = middle; else high = middle;
  }
  const share = (time - times[low]) / (times[high] - times[low]);
  return values[low] + share * (values[high] - values[low]);
}

// A name without what programs add: `head.jawOpen`, `JawOpen`, `jaw_open` and `jawOpen.001` are one, and the
// side of `eyeBlink_L` and `eyeBlink.L` is written in full.
export function plainName(name) {
  const bare = (name.replace(/([._]\d{3}|_div\d)+$/, "") || name).replace(/(?<=[a-z])\.(?=[LR]$)/, "_");
  const last = bare.slice(bare.lastIndexOf(".") + 1);
  const side = /^(.+[a-z])_?([LR])$/.exec(last) ?? /^(.+)_([lr])$/.exec(last);
  const full = side ? side[1] + SIDES[side[2].toLowerCase()] : last;
  return full.replace(/[\s_-]/g, "").toLowerCase();
}

export class LinePlayer {
  // `object`: a three.js object with meshes below it. Options: `rest`, seconds of the way back to rest (0.2);
  // `names`, a table from channels to the names of shapes; `head`, the bone that turns; `expressions`, the
  // expressionManager of a VRM, which is then moved in place of the meshes.
  constructor(object, { rest = 0.2, names = {}, head = null, expressions = null } = {}) {
    this.rest = rest;
    this.names = names;
    this.shapes = expressions ? expressionShapes(expressions) : meshShapes(object);
    this.head = head && { bone: head, rest: head.quaternion.toArray() };
    this.line = null; // { track, audio, time, onEnd }
    this.goal = new Map(); // weights to show, by channel
    this.shown = new Map(); // weights that are shown
    this.from = new Map(); // weights from which the present blend began
    this.blend = 1; // 0 .. 1, the part of the blend that is done
  }

  // The channels of a track that no shape of the object has; empty when the whole line shows.
  missing(track) {
    return track.channels.map(({ name }) => name)
      .filter((name) => !this.#targets(name).length && !(this.head && TURNS.includes(name)));
  }

  // Speak a line from its beginning; one that is being spoken gives way within `rest` seconds. `audio` is an
  // HTMLAudioElement, or anything with `currentTime`, `ended`, `play` and `pause`; it is the clock. Where it cannot
  // play (before the visitor has touched the page, or without the file), a warning says so and the line goes on
  // silently. `onEnd` is called when the line has ended, with false when it was interrupted.
  play(track, { audio = null, onEnd = null } = {}) {
    this.#leave(false);
    const line = { track, audio, time: 0, onEnd };
    this.line = line;
    this.#begin();
    if (audio) {
      audio.currentTime = 0;
      Promise.resolve(audio.play()).catch((error) => {
        if (this.line !== line) return; // interrupted before the sound began
        console.warn(`phonanim: the sound does not play: ${error.message}`);
        line.audio = null;
      });
    }
  }

  // Interrupt the line, or end live motion: everything goes back to rest.
  stop() {
    this.#leave(false);
    this.goal = new Map();
    this.#begin();
  }

  get speaking() {
    return this.line !== null;
  }

  // Show weights by name from now on, such as a live frame: a Map or a table. A line that is spoken is interrupted.
  show(weights) {
    if (this.line) {
      this.#leave(false);
      this.#begin();
    }
    this.goal = weights instanceof Map ? weights : new Map(Object.entries(weights));
  }

  // Follow `phonanim stream --to websocket`, at an address such as ws://127.0.0.1:8765/live. Returns the socket;
  // when it closes, the face goes back to rest. Close it before you play a line.
  listen(url, WebSocketClass = globalThis.WebSocket) {
    const socket = new WebSocketClass(url);
    let controls = [];
    socket.binaryType = "arraybuffer";
    socket.onmessage = ({ data }) => {
      if (typeof data === "string") controls = JSON.parse(data).controls;
      else this.show(new Map(Array.from(new Float32Array(data, 16), (value, n) => [controls[n], value])));
    };
    socket.onclose = () => this.speaking || this.stop();
    return socket;
  }

  // Move on by `seconds` and set the weights. Call it in each frame, before `vrm.update()`.
  update(seconds) {
    if (this.line) this.#speak(seconds);
    this.blend = this.rest > 0 ? Math.min(1, this.blend + seconds / this.rest) : 1;
    const ease = this.blend * this.blend * (3 - 2 * this.blend);
    for (const name of new Set([...this.goal.keys(), ...this.shown.keys()])) {
      const goal = this.goal.get(name) ?? 0;
      const start = this.from.get(name) ?? 0;
      this.shown.set(name, start + (goal - start) * ease);
    }
    this.#apply();
  }

  #speak(seconds) {
    const { track, audio } = this.line;
    this.line.time = audio ? audio.currentTime : this.line.time + seconds;
    for (const channel of track.channels) this.goal.set(channel.name, valueAt(channel, this.line.time));
    if (audio ? audio.ended : this.line.time >= track.duration) {
      this.#leave(true);
      this.goal = new Map();
      this.#begin();
    }
  }

  #leave(whole) {
    const line = this.line;
    this.line = null;
    if (!line) return;
    if (!whole) line.audio?.pause();
    line.onEnd?.(whole);
  }

  // Blend from what is shown now.
  #begin() {
    this.from = new Map(this.shown);
    this.goal = new Map();
    this.blend = 0;
  }

  #targets(name) {
    const wanted = this.names[name] ?? name;
    return this.shapes.get(wanted) ?? this.shapes.get(plainName(wanted)) ?? [];
  }

  // Several channels may move one shape, so weights are summed before they are set.
  #apply() {
    const sums = new Map();
    for (const [name, weight] of this.shown) {
      for (const shape of this.#targets(name)) sums.set(shape, (sums.get(shape) ?? 0) + weight);
    }
    for (const [shape, weight] of sums) shape.set(weight);
    if (this.head) this.#turn(TURNS.map((name) => this.shown.get(name) ?? 0));
    for (const [name, weight] of this.shown) {
      if (this.blend === 1 && weight === 0 && !this.goal.has(name)) this.shown.delete(name);
    }
  }

  // Pitch about x, yaw about y, roll about z, in the axes of the bone's parent; roll first, yaw last.
  #turn(degrees) {
    const [x, y, z] = degrees.map((angle, axis) => {
      const half = (angle * Math.PI) / 360;
      return Object.assign([0, 0, 0, Math.cos(half)], { [axis]: Math.sin(half) });
    });
    this.head.bone.quaternion.fromArray([y, x, z, this.head.rest].reduce(multiplied));
  }
}

// Every shape of the meshes below an object, under its name and its plain name.
function meshShapes(object) {
  const shapes = new Map();
  object.traverse((mesh) => {
    for (const [name, index] of Object.entries(mesh.morphTargetDictionary ?? {})) {
      const influences = mesh.morphTargetInfluences;
      const shape = { set: (weight) => { influences[index] = weight; } };
      for (const known of new Set([name, plainName(name)])) {
        shapes.set(known, [...(shapes.get(known) ?? []), shape]);
      }
    }
  });
  return shapes;
}

function expressionShapes(manager) {
  const shapes = new Map();
  for (const name of Object.keys(manager.expressionMap)) {
    const shape = { set: (weight) => manager.setValue(name, weight) };
    for (const known of new Set([name, plainName(name)])) shapes.set(known, [shape]);
  }
  return shapes;
}

// The product of two quaternions, [x, y, z, w] each.
function multiplied([ax, ay, az, aw], [bx, by, bz, bw]) {
  return [
    aw * bx + ax * bw + ay * bz - az * by,
    aw * by - ax * bz + ay * bw + az * bx,
    aw * bz + ax * by - ay * bx + az * bw,
    aw * bw - ax * bx - ay * by - az * bz,
  ];
}
