// Chance that can be drawn again: the same participant always sees the same order and sides.

// FNV-1a, 32 bits.
function seedOf(text) {
  let hash = 0x811c9dc5;
  for (const byte of new TextEncoder().encode(text)) hash = Math.imul(hash ^ byte, 0x01000193);
  return hash >>> 0;
}

// Mulberry32: numbers from 0 to 1.
function generator(seed) {
  let state = seed;
  return () => {
    state = (state + 0x6d2b79f5) >>> 0;
    let mixed = Math.imul(state ^ (state >>> 15), state | 1);
    mixed = (mixed + Math.imul(mixed ^ (mixed >>> 7), mixed | 61)) ^ mixed;
    return ((mixed ^ (mixed >>> 14)) >>> 0) / 4294967296;
  };
}

function shuffled(list, random) {
  const mixed = [...list];
  for (let last = mixed.length - 1; last > 0; last--) {
    const other = Math.floor(random() * (last + 1));
    [mixed[last], mixed[other]] = [mixed[other], mixed[last]];
  }
  return mixed;
}

// Practice first, then test and control trials in one random order; for each, whether the sides are swapped.
function orderFor(trials, limit, seed) {
  const random = generator(seed);
  const of = (kind) => shuffled(trials.keys(), random).filter((index) => trials[index].kind === kind);
  const test = of("test");
  const judged = shuffled([...test.slice(0, limit || test.length), ...of("control")], random);
  return [...of("practice"), ...judged].map((trial) => ({ trial, swapped: random() < 0.5 }));
}
