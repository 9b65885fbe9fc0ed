// Waveform, words, phones and chosen curves over time; the hand on it moves the time.

const ROWS = { ruler: 20, wave: 46, words: 24, phones: 24 };
const SQUEEZED = 0.55;
const COLORS = ["#e0896e", "#6fb3d9", "#9fcf7a", "#d9b45f", "#b794e0", "#e07fb0", "#6fd0bd", "#c9c9c9"];

class Timeline {
  constructor(section, takes, duration, seek) {
    this.canvas = section.querySelector("canvas");
    this.section = section;
    this.takes = takes;
    this.duration = duration;
    this.span = [0, duration];
    this.wave = null;
    this.shown = [];
    this.listen(seek);
  }

  listen(seek) {
    const timeOf = (event) => this.time(event.clientX - this.canvas.getBoundingClientRect().left);
    this.canvas.addEventListener("pointerdown", (event) => {
      this.canvas.setPointerCapture(event.pointerId);
      seek(timeOf(event));
    });
    this.canvas.addEventListener("pointermove", (event) => event.buttons && seek(timeOf(event)));
    this.canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.zoom(timeOf(event), Math.exp(event.deltaY * 0.002), event.deltaX / 600);
    }, { passive: false });
    this.timeOf = timeOf;
  }

  zoom(about, factor, shift) {
    const width = Math.min(Math.max((this.span[1] - this.span[0]) * factor, 0.1), this.duration);
    const share = (about - this.span[0]) / (this.span[1] - this.span[0]);
    const start = about - share * width + shift * width;
    this.scroll(Math.min(Math.max(start, 0), this.duration - width), width);
  }

  scroll(start, width) {
    this.span = [start, start + width];
  }

  // Keep the moving time in sight.
  follow(time) {
    const width = this.span[1] - this.span[0];
    if (time < this.span[0] || time > this.span[1]) this.scroll(Math.min(time, this.duration - width), width);
  }

  time(x) {
    const time = this.span[0] + (x / this.canvas.clientWidth) * (this.span[1] - this.span[0]);
    return Math.min(Math.max(time, 0), this.duration);
  }

  x(time) {
    return ((time - this.span[0]) / (this.span[1] - this.span[0])) * this.canvas.clientWidth;
  }

  draw(time) {
    const { clientWidth: width, clientHeight: height } = this.section;
    const ratio = window.devicePixelRatio;
    this.canvas.width = width * ratio;
    this.canvas.height = height * ratio;
    const pen = this.canvas.getContext("2d");
    pen.scale(ratio, ratio);
    pen.font = '12px system-ui, "Segoe UI", "Noto Sans", sans-serif';
    pen.textAlign = "center";
    pen.textBaseline = "middle";
    let top = 0;
    this.drawRuler(pen, top, width, height);
    top += ROWS.ruler;
    if (this.wave) {
      this.drawWave(pen, top, width);
      top += ROWS.wave;
    }
    this.takes.forEach((take, number) => {
      if (number > 0 && sameLabels(take, this.takes[0])) return;
      top = this.drawSpans(pen, take.words, top, ROWS.words, time, "#262a32");
      top = this.drawSpans(pen, take.phones, top, ROWS.phones, time, "#2c313b");
    });
    this.drawCurves(pen, top + 6, height - top - 12, width);
    pen.fillStyle = "#ffffff";
    pen.fillRect(Math.round(this.x(time)) - 0.5, 0, 1.5, height);
  }

  drawRuler(pen, top, width, height) {
    const steps = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 30, 60, 300];
    const perPixel = (this.span[1] - this.span[0]) / width;
    const step = steps.find((candidate) => candidate / perPixel > 64) || 600;
    for (let i = Math.ceil(this.span[0] / step); i * step <= this.span[1]; i++) {
      pen.fillStyle = "#262a32";
      pen.fillRect(this.x(i * step), top + ROWS.ruler, 1, height);
      pen.fillStyle = "#8e96a3";
      pen.fillText(`${+(i * step).toFixed(2)} s`, this.x(i * step), top + ROWS.ruler / 2);
    }
  }

  drawWave(pen, top, width) {
    const { samples, rate } = this.wave;
    pen.fillStyle = "#5d6b80";
    for (let x = 0; x < width; x++) {
      const [first, last] = [x, x + 1].map((edge) => Math.floor(this.time(edge) * rate));
      let low = 0, high = 0;
      const stride = Math.max(1, Math.floor((last - first) / 64));
      for (let i = first; i < last && i < samples.length; i += stride) {
        low = Math.min(low, samples[i]);
        high = Math.max(high, samples[i]);
      }
      const middle = top + ROWS.wave / 2;
      pen.fillRect(x, middle - high * ROWS.wave * 0.5, 1, Math.max(1, (high - low) * ROWS.wave * 0.5));
    }
  }

  drawSpans(pen, intervals, top, height, time, fill) {
    for (const [label, start, end] of intervals) {
      const left = this.x(start), right = this.x(end);
      if (right < 0 || left > this.canvas.clientWidth) continue;
      const current = start <= time && time < end;
      pen.fillStyle = current && label ? "#e0896e" : fill;
      pen.fillRect(left + 0.5, top + 1, Math.max(1, right - left - 1), height - 2);
      pen.fillStyle = current ? "#201510" : "#eceef2";
      const middle = (Math.max(left, 0) + Math.min(right, this.canvas.clientWidth)) / 2;
      writeWithin(pen, label, middle, top + height / 2, right - left - 2);
    }
    return intervals.length ? top + height : top;
  }

  // The first take is drawn in full lines, the second in broken ones; 10 mm of articulation are as high as a weight of 1.
  drawCurves(pen, top, height, width) {
    const rangeOf = (take, name) => take.range[take.channels.indexOf(name)]?.map((edge) => edge / scaleOf(name));
    const known = this.shown.flatMap(({ name }) => this.takes.map((take) => rangeOf(take, name))).filter(Boolean);
    const low = Math.min(0, ...known.map(([a]) => a)), high = Math.max(0.05, ...known.map(([, b]) => b));
    this.area = { top, height, low, high };
    pen.fillStyle = "#8e96a3";
    pen.textAlign = "left";
    pen.fillText(high.toFixed(2), 4, top + 4);
    pen.lineWidth = 1.6;
    for (const { name, color } of this.shown) {
      this.takes.forEach((take, number) => {
        const channel = take.channels.indexOf(name);
        if (channel < 0) return;
        pen.strokeStyle = color;
        pen.setLineDash(number ? [4, 4] : []);
        pen.beginPath();
        for (let x = 0; x <= width; x++) {
          const y = top + height * (1 - (take.at(channel, this.time(x)) / scaleOf(name) - low) / (high - low));
          x ? pen.lineTo(x, y) : pen.moveTo(x, y);
        }
        pen.stroke();
      });
    }
    pen.setLineDash([]);
    pen.textAlign = "center";
  }
}

// A label squeezed into its room, to SQUEEZED of its width; what is longer still is cut.
function writeWithin(pen, label, x, y, room) {
  const fits = (text) => pen.measureText(text).width * SQUEEZED <= room;
  let text = label;
  for (let kept = label.length - 1; !fits(text) && kept > 0; kept--) text = `${label.slice(0, kept)}…`;
  if (fits(text)) pen.fillText(text, x, y, Math.max(room, 1));
}

function sameLabels(a, b) {
  return JSON.stringify([a.words, a.phones]) === JSON.stringify([b.words, b.phones]);
}
