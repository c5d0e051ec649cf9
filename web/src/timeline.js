// The slider, what became of each frame above it, and the current frame's figures.
import { byId, element, figure } from './dom.js';
import { color, onThemeChange } from './theme.js';

const PLAY = 'M4 2.5v11l9-5.5z';
const PAUSE = 'M4 2.5h3v11H4zM9 2.5h3v11H9z';

/** One column of pixels stands for one or more frames; a lost one among them is never hidden. */
function drawRibbon(canvas, frames, lostStatus) {
  const ratio = devicePixelRatio || 1;
  canvas.width = Math.max(1, Math.round(canvas.clientWidth * ratio));
  canvas.height = Math.max(1, Math.round(canvas.clientHeight * ratio));
  const context = canvas.getContext('2d');
  context.fillStyle = color('tracked');
  context.fillRect(0, 0, canvas.width, canvas.height);
  context.fillStyle = color('lost');
  const width = canvas.width / frames.rows;
  frames.column('status').forEach((status, row) => {
    if (status === lostStatus) context.fillRect(Math.floor(row * width), 0, Math.max(ratio, Math.ceil(width)), canvas.height);
  });
}

function readout(report, row) {
  const { frames, names } = report;
  const at = (name) => frames.at(name, row);
  const status = names.status[at('status')];
  const reason = names.reason[at('reason')];
  const parts = [
    ['frame', `${at('index')}`],
    ['time', figure(at('time_s'), 2, 's')],
    ['status', status === 'lost' ? `lost: ${reason.replaceAll('_', ' ')}` : status],
    ['matched', figure(100 * at('inlier_fraction'), 0, '%')],
  ];
  if (frames.has('error_m')) parts.push(['from truth', figure(1e3 * at('error_m'), 1, 'mm')]);
  return parts.map(([label, value]) =>
    element('span', { class: label === 'status' ? status : '' }, element('small', {}, label), value));
}

/** Steps through the frames at the speed at which they were recorded, within reason. */
class Player {
  constructor(button, report, cursor) {
    this.button = button;
    this.cursor = cursor;
    this.times = report.frames.column('time_s');
    this.running = false;
    button.addEventListener('click', () => this.toggle());
    this.icon();
  }

  icon() {
    this.button.innerHTML = `<svg viewBox="0 0 16 16" aria-hidden="true"><path d="${this.running ? PAUSE : PLAY}" fill="currentColor"/></svg>`;
    this.button.setAttribute('aria-label', this.running ? 'Pause' : 'Play');
  }

  toggle() {
    this.running = !this.running;
    this.icon();
    if (!this.running) return;
    if (this.cursor.row >= this.cursor.rows - 1) this.cursor.go(0);
    const begin = performance.now();
    const from = this.times[this.cursor.row];
    const step = (now) => {
      if (!this.running) return;
      const time = from + (now - begin) / 1e3;
      let row = this.cursor.row;
      while (row < this.cursor.rows - 1 && this.times[row] < time) row++;
      if (row !== this.cursor.row) this.cursor.go(row);
      if (row >= this.cursor.rows - 1) this.toggle();
      else requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  stop() {
    if (this.running) this.toggle();
  }
}

export function showTimeline(report, cursor) {
  const slider = byId('frame');
  const ribbon = byId('ribbon');
  byId('timeline').hidden = false;
  slider.max = String(cursor.rows - 1);
  const player = new Player(byId('play'), report, cursor);
  slider.addEventListener('input', () => {
    player.stop();
    cursor.go(slider.valueAsNumber);
  });
  const draw = () => drawRibbon(ribbon, report.frames, report.names.status.indexOf('lost'));
  new ResizeObserver(draw).observe(ribbon);
  onThemeChange(draw);
  cursor.onChange((row) => {
    slider.value = String(row);
    slider.setAttribute('aria-valuetext', `frame ${report.frames.at('index', row)}`);
    byId('readout').replaceChildren(...readout(report, row));
  });
}
