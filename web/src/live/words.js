// What the page says.
import { byId, element, figure } from '../dom.js';

const HOLD = 900; // milliseconds that a hint stays at least: words that flicker are not read
const FIGURES = 250; // milliseconds that figures stay
const MINOR = new Set(['time a frame', 'matched']); // left out where there is little room
const URGENT = new Set(['back', 'confirm', 'slower', 'little', 'closer', 'farther']);
const ICONS = {
  back: 'M9 5 4 10l5 5M4 10h10a5 5 0 0 1 0 10h-3',
  confirm: 'M4 12.5 9.5 18 20 6',
  slower: 'M12 4a8 8 0 0 0-8 8c0 3 1.5 5 3 6.5M12 4a8 8 0 0 1 8 8c0 3-1.5 5-3 6.5M12 12 8 8.5',
  little: 'M4 6h16v12H4zM8 15l3-4 2.5 3 1.5-2 2 3',
  closer: 'M12 4v12M7 11l5 5 5-5M5 20h14',
  farther: 'M12 16V4M7 9l5-5 5 5M5 20h14',
  sensor: 'M12 4v9M12 17v1.5',
};
const REASONS = {
  no_depth: 'no depth', few_inliers: 'too little fits the surface', singular: 'too little to hold on to',
  implausible_step: 'too far from where it was', unknown_place: 'a place that is not known', unconfirmed: 'not the place that it seemed',
};
const PHASES = {
  ready: 'Ready', running: 'Scanning', paused: 'Paused', going_back: 'Going back', finishing: 'Saving', finished: 'Saved', failed: 'Ended',
};

export class Words {
  setScene(scene) {
    this.scene = scene;
    document.title = `${scene.title ?? 'Plumbline'} – Plumbline`;
    byId('title').textContent = scene.title ?? 'Plumbline';
    document.body.classList.toggle('images-only', scene.map === false);
  }

  update(state, page) {
    this.status(state);
    this.hints(state);
    this.figures(state, page);
    this.progress(state);
    if (['going_back', 'finishing', 'failed', 'finished'].includes(state.phase)) this.curtain(curtainOf(state));
    else if (page.isOpen) this.curtain(null);
  }

  status(state) {
    const { frame, phase } = state;
    const isLost = phase === 'running' && frame?.status === 'lost';
    const text = isLost ? `Lost: ${REASONS[frame.reason] ?? frame.reason}` : (this.scene?.map === false && phase === 'running' ? 'Recording' : PHASES[phase] ?? '');
    const status = byId('status');
    setText(status, text);
    status.dataset.kind = isLost ? 'lost' : phase;
    document.body.dataset.phase = phase;
  }

  hints({ hints = [], phase }) {
    const running = phase === 'running' ? hints : [];
    this.main(running.find(({ kind }) => URGENT.has(kind)) ?? (phase === 'ready' ? { kind: 'ready', text: 'Aim, then start', detail: 'Begin with things and edges in view, one to two metres away.' } : null));
    const rest = hints.filter(({ kind }) => !URGENT.has(kind));
    const text = JSON.stringify(rest);
    if (text === this.restText) return;
    this.restText = text;
    byId('aside-hints').replaceChildren(...rest.map(({ text, detail }) => element('p', {}, element('b', {}, text), ` ${detail}`)));
  }

  main(hint) {
    const now = performance.now();
    if (hint?.kind !== this.hint?.kind && this.hint && this.hint.kind !== 'ready' && now - this.hintSince < HOLD && hint?.kind !== 'back') return;
    if (hint?.kind !== this.hint?.kind) this.hintSince = now;
    this.hint = hint;
    const box = byId('hint');
    box.hidden = !hint;
    if (!hint) return;
    box.dataset.kind = hint.kind;
    byId('hint-icon').setAttribute('d', ICONS[hint.kind] ?? 'M12 5v9M12 18v.5');
    setText(byId('hint-text'), hint.text);
    setText(byId('hint-detail'), hint.detail);
  }

  /** Numbers that change with every frame cannot be read, and laying them out takes time. */
  figures(state, page) {
    const now = performance.now(), key = `${state.phase} ${this.scene?.map}`;
    if (key === this.figuresKey && now - this.figuresAt < FIGURES) return;
    [this.figuresKey, this.figuresAt] = [key, now];
    const rows = this.rows(state, page);
    const list = byId('figures');
    if (list.childElementCount !== rows.length || rows.some(([label], i) => list.children[i].firstChild.textContent !== label))
      list.replaceChildren(...rows.map(([label, value]) => element('div', { class: MINOR.has(label) ? 'minor' : false }, element('dt', {}, label), element('dd', {}, value))));
    else rows.forEach(([, value], i) => setText(list.children[i].lastChild, value));
  }

  rows({ frame, frames = 0, tracked = 0, rate, dropped, sensor, orientation }, { viewer }) {
    const rows = [['frames a second', figure(rate, 0, '')]];
    if (this.scene?.map === false) {
      rows.push(['frames', String(frames)]);
    } else {
      rows.push(['time a frame', figure(frame?.milliseconds, 1, 'ms')]);
      rows.push(['tracked', frames ? `${tracked} of ${frames}` : '–'], ['matched', frame ? figure(100 * frame.matched, 0, '%') : '–']);
      rows.push(['triangles', viewer.surface.triangles.toLocaleString('en').replaceAll(',', '\u202f')]);
    }
    if (dropped > 0) rows.push(['dropped', String(dropped)]);
    if (sensor || (orientation && !['off', 'missing', 'first'].includes(orientation))) rows.push(['sensor', sensor || orientation]);
    return rows;
  }

  progress({ frames = 0, phase }) {
    const { total } = this.scene ?? {};
    byId('progress').hidden = !(total > 0) || phase === 'finishing';
    const width = `${Math.min(100, Math.round((1000 * frames) / total) / 10)}%`;
    const { style } = byId('progress').firstElementChild;
    if (total > 0 && style.width !== width) style.width = width;
  }

  /** Over everything: what has to be waited for; null: nothing. */
  curtain(what) {
    const curtain = byId('curtain');
    curtain.hidden = !what;
    if (!what) return;
    curtain.querySelector('b').textContent = what.title;
    curtain.querySelector('p').textContent = what.text ?? '';
    curtain.querySelector('.progress').hidden = !(what.progress > 0);
    curtain.querySelector('i').style.width = `${100 * (what.progress ?? 0)}%`;
  }
}

function setText(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

function curtainOf({ phase, note, progress }) {
  if (phase === 'going_back') return { title: 'Going back', text: `The frames that stay are fused again: ${note}`, progress };
  if (phase === 'finishing') return { title: 'Saving', text: note, progress };
  if (phase === 'failed') return { title: 'The run has ended', text: note };
  return { title: 'Saved', text: note || 'The report follows.' };
}
