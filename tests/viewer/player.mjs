// Tests of examples/web/phonanim-player.js on meshes that are stubs: node tests/viewer/player.mjs MODULE
import assert from "node:assert/strict";
import { pathToFileURL } from "node:url";

const { LinePlayer, parseTrack, plainName, valueAt } = await import(pathToFileURL(process.argv[2]).href);

const TRACK = {
  format: "openfacefx.track",
  version: 1,
  fps: 60,
  duration: 1,
  channels: [
    { name: "jawOpen", keys: [[0, 0.5], [0.5, 1], [1, 0]] },
    { name: "eyeBlinkLeft", keys: [[0.25, 0.25]] },
    { name: "headYaw", keys: [[0, 90]] },
  ],
};

function mesh(...names) {
  const shapes = Object.fromEntries(names.map((name, index) => [name, index]));
  return { morphTargetDictionary: shapes, morphTargetInfluences: names.map(() => 0.125) };
}

function scene(...meshes) {
  return { traverse: (visit) => [{}, ...meshes].forEach(visit) };
}

function bone(...rest) {
  return { quaternion: { value: rest, toArray() { return this.value; }, fromArray(to) { this.value = to; } } };
}

const near = (found, wanted) => assert.ok(Math.abs(found - wanted) < 1e-6, `${found} is not ${wanted}`);
const tests = {
  "names are matched as the exporters match them"() {
    for (const name of ["jawOpen", "JawOpen", "jaw_open", "head.jawOpen", "Jaw Open"]) assert.equal(plainName(name), "jawopen");
    for (const name of ["eyeBlinkLeft", "eyeBlink_L", "EyeBlinkL", "eye_blink_l"]) assert.equal(plainName(name), "eyeblinkleft");
    assert.equal(plainName("mouthRoll"), "mouthroll");
  },
  "keys are straight between, and held outside"() {
    const [jaw, blink] = parseTrack(TRACK).channels;
    near(valueAt(jaw, 0.25), 0.75);
    near(valueAt(jaw, 0.75), 0.5);
    near(valueAt(jaw, -1), 0.5);
    near(valueAt(jaw, 9), 0);
    near(valueAt(blink, 0.7), 0.25);
    near(valueAt({ times: [], values: [] }, 0), 0);
  },
  "another format is refused"() {
    assert.throws(() => parseTrack({ format: "x" }), /not an OpenFaceFX track of version 1: x undefined/);
    assert.throws(() => parseTrack(null));
  },
  "a line moves every mesh that has its shapes, and nothing else"() {
    const one = mesh("Face.jawOpen", "hat"), two = mesh("JawOpen", "eyeBlink_L");
    const face = new LinePlayer(scene(one, two), { rest: 0 });
    assert.deepEqual(face.missing(parseTrack(TRACK)), ["headYaw"]);
    face.play(parseTrack(TRACK));
    face.update(0.25);
    near(one.morphTargetInfluences[0], 0.75);
    near(two.morphTargetInfluences[0], 0.75);
    near(two.morphTargetInfluences[1], 0.25);
    assert.equal(one.morphTargetInfluences[1], 0.125);
    face.update(0.25);
    near(one.morphTargetInfluences[0], 1);
  },
  "an interrupted line is at rest after 200 ms, and on the way before"() {
    const one = mesh("jawOpen");
    const face = new LinePlayer(scene(one));
    const ended = [];
    face.play(parseTrack(TRACK), { onEnd: (whole) => ended.push(whole) });
    for (let frame = 0; frame < 30; frame++) face.update(1 / 60);
    near(one.morphTargetInfluences[0], 1);
    face.stop();
    assert.deepEqual([face.speaking, ended], [false, [false]]);
    let before = 1;
    for (let frame = 0; frame < 12; frame++) {
      face.update(1 / 60);
      assert.ok(one.morphTargetInfluences[0] < before && before - one.morphTargetInfluences[0] < 0.15);
      before = one.morphTargetInfluences[0];
    }
    near(one.morphTargetInfluences[0], 0);
    one.morphTargetInfluences[0] = 0.5; // another animation has it now
    face.update(1 / 60);
    near(one.morphTargetInfluences[0], 0.5);
  },
  "a line that ends goes to rest and says that it was whole"() {
    const one = mesh("jawOpen");
    const face = new LinePlayer(scene(one));
    let whole = null;
    face.play(parseTrack(TRACK), { onEnd: (value) => { whole = value; } });
    for (let frame = 0; frame < 75; frame++) face.update(1 / 60);
    assert.equal(whole, true);
    near(one.morphTargetInfluences[0], 0);
  },
  "a second line takes over without a jump"() {
    const one = mesh("jawOpen");
    const face = new LinePlayer(scene(one));
    face.play(parseTrack(TRACK));
    face.update(0.5);
    near(one.morphTargetInfluences[0], 1);
    const shut = { ...TRACK, channels: [{ name: "jawOpen", keys: [[0, 0]] }] };
    face.play(parseTrack(shut));
    face.update(0.01);
    assert.ok(one.morphTargetInfluences[0] > 0.95);
    face.update(0.2);
    near(one.morphTargetInfluences[0], 0);
  },
  "the sound is the clock, and stops with the line"() {
    const calls = [];
    const audio = { currentTime: 3, ended: false, play: () => calls.push("play"), pause: () => calls.push("pause") };
    const one = mesh("jawOpen");
    const face = new LinePlayer(scene(one), { rest: 0 });
    face.play(parseTrack(TRACK), { audio });
    assert.equal(audio.currentTime, 0);
    audio.currentTime = 0.5;
    face.update(9);
    near(one.morphTargetInfluences[0], 1);
    face.stop();
    assert.deepEqual(calls, ["play", "pause"]);
    face.play(parseTrack(TRACK), { audio });
    audio.ended = true;
    face.update(0.1);
    assert.equal(face.speaking, false);
    assert.deepEqual(calls, ["play", "pause", "play"]);
  },
  async "a sound that may not play leaves the line silent"() {
    const warned = [];
    console.warn = (text) => warned.push(text);
    const audio = { currentTime: 0, ended: false, play: () => Promise.reject(new Error("not allowed")), pause() {} };
    const one = mesh("jawOpen");
    const face = new LinePlayer(scene(one), { rest: 0 });
    face.play(parseTrack(TRACK), { audio });
    await new Promise(setImmediate);
    assert.deepEqual(warned, ["phonanim: the sound does not play: not allowed"]);
    face.update(0.5);
    near(one.morphTargetInfluences[0], 1);
    face.play(parseTrack(TRACK), { audio });
    face.stop(); // what is interrupted at once warns of nothing
    await new Promise(setImmediate);
    assert.equal(warned.length, 1);
  },
  "the head turns from its rest, and back"() {
    const head = bone(0, 1, 0, 0); // half a turn
    const face = new LinePlayer(scene(mesh("jawOpen")), { head, rest: 0.2 });
    assert.deepEqual(face.missing(parseTrack(TRACK)), ["eyeBlinkLeft"]);
    face.play(parseTrack(TRACK));
    face.update(0.3);
    [0, Math.SQRT1_2, 0, -Math.SQRT1_2].forEach((part, n) => near(head.quaternion.value[n], part));
    face.stop();
    face.update(0.2);
    [0, 1, 0, 0].forEach((part, n) => near(head.quaternion.value[n], part));
  },
  "a table of names leads channels to shapes, which add up"() {
    const one = mesh("open");
    const face = new LinePlayer(scene(one), { rest: 0, names: { jawOpen: "open", eyeBlinkLeft: "open" } });
    face.play(parseTrack(TRACK));
    face.update(0.25);
    near(one.morphTargetInfluences[0], 1);
  },
  "expressions of a VRM"() {
    const set = [];
    const expressions = { expressionMap: { JawOpen: {} }, setValue: (...call) => set.push(call) };
    const face = new LinePlayer(null, { expressions, rest: 0 });
    face.play(parseTrack(TRACK));
    face.update(0.5);
    assert.deepEqual(set, [["JawOpen", 1]]);
  },
  "a live stream moves the face until it closes"() {
    class Socket { constructor(url) { this.url = url; } }
    const one = mesh("jawOpen", "jawLeft");
    const face = new LinePlayer(scene(one));
    face.play(parseTrack(TRACK));
    const socket = face.listen("ws://127.0.0.1:8765/live", Socket);
    assert.equal(socket.url, "ws://127.0.0.1:8765/live");
    socket.onmessage({ data: JSON.stringify({ rig: "arkit", fps: 60, controls: ["jawLeft", "jawOpen"] }) });
    assert.equal(face.speaking, true);
    const packet = new ArrayBuffer(16 + 8);
    new Float32Array(packet, 16).set([0.25, 0.75]);
    socket.onmessage({ data: packet });
    assert.equal(face.speaking, false);
    face.update(0.2);
    near(one.morphTargetInfluences[0], 0.75);
    near(one.morphTargetInfluences[1], 0.25);
    socket.onclose();
    face.update(0.2);
    near(one.morphTargetInfluences[0], 0);
    face.play(parseTrack(TRACK));
    socket.onclose(); // a stream that ends late does not interrupt a line
    assert.equal(face.speaking, true);
  },
};
for (const [name, test] of Object.entries(tests)) {
  try {
    await test();
  } catch (error) {
    console.error(`${name}: ${error.stack}`);
    process.exitCode = 1;
  }
}
console.log(`${Object.keys(tests).length} tests`);
