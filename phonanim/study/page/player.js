// Two films side by side, of which one plays at a time. A take may have the sound of another film.
class Player {
  constructor(sides, films, watched, failed) {
    this.sides = sides;
    this.films = films;
    this.watched = watched;
    this.failed = failed;
    this.plays = {};
    this.sounds = {};
    this.queue = [];
    for (const [side, video] of Object.entries(sides)) {
      video.addEventListener("ended", () => this.ended(side));
      video.addEventListener("error", () => failed(side));
    }
  }

  show(takes) {
    this.stop();
    for (const [side, take] of Object.entries(takes)) {
      this.plays[side] = 0;
      this.sides[side].src = this.films[take.picture];
      this.sides[side].muted = take.sound !== take.picture;
      this.sounds[side] = take.sound === take.picture ? null : new Audio(this.films[take.sound]);
    }
  }

  play(...queue) {
    this.stop();
    const [side, ...rest] = queue;
    this.queue = rest;
    this.sides[side].classList.add("playing");
    for (const part of this.parts(side)) {
      part.currentTime = 0;
      part.play().catch((error) => {
        // A play that is cut short by stop() is no fault.
        if (error.name !== "AbortError") this.failed(side);
      });
    }
  }

  stop() {
    this.queue = [];
    for (const side in this.sides) {
      for (const part of this.parts(side)) part.pause();
      this.sides[side].classList.remove("playing");
    }
  }

  parts(side) {
    return [this.sides[side], this.sounds[side]].filter(Boolean);
  }

  ended(side) {
    const queue = this.queue;
    this.stop();
    this.plays[side] += 1;
    this.watched();
    if (queue.length) this.play(...queue);
  }
}
