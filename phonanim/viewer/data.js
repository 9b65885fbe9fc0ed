// What the page holds: takes with their curves, the sound, the head.

function bytesOf(text) {
  return Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
}

function readTake(raw) {
  const values = new Float32Array(bytesOf(raw.curves).buffer); // frame after frame
  const width = raw.channels.length;
  const frames = values.length / width;
  const take = { ...raw, frames, end: raw.start + (frames - 1) / raw.fps };
  // The value of a channel at a time, straight between frames.
  take.at = (channel, time) => {
    const place = Math.min(Math.max((time - raw.start) * raw.fps, 0), frames - 1);
    const first = Math.floor(place);
    const next = Math.min(first + 1, frames - 1);
    const a = values[first * width + channel];
    return a + (values[next * width + channel] - a) * (place - first);
  };
  take.value = (channel, frame) => values[frame * width + channel];
  // How much a channel moves: its range.
  take.range = raw.channels.map((_, channel) => {
    let low = Infinity, high = -Infinity;
    for (let i = channel; i < values.length; i += width) {
      low = Math.min(low, values[i]);
      high = Math.max(high, values[i]);
    }
    return [low, high];
  });
  return take;
}

function intervalAt(intervals, time) {
  return intervals.find(([, start, end]) => start <= time && time < end);
}

// What counts as one on a common axis: curves of articulation are in millimetres, controls are weights.
function scaleOf(name) {
  return name.endsWith(" mm") ? 10 : 1;
}
