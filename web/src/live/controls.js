// Buttons and keys.
import { byId, element } from '../dom.js';

const UNDO = 5; // seconds
const ICONS = {
  start: 'M7 4v16l13-8z', pause: 'M7 4h4v16H7zM14 4h4v16h-4z', undo: 'M9 5 4 10l5 5M4 10h10a5 5 0 0 1 0 10h-3',
  reset: 'M19 12a7 7 0 1 1-2.2-5.1M19 3v5h-5', crop: 'M7 2v15h15M2 7h15v15', finish: 'M4 12.5 9.5 18 20 6',
};
// Name, words, words where there is little room, key.
const SHADINGS = [['colour', 'Colour', 'Colour', '1'], ['clay', 'Clay', 'Clay', '2'], ['seen', 'How well seen', 'Seen', '3']];
const MODES = [['follow', 'Follow', 'Follow', 'F'], ['scene', 'All of it', 'All', 'A'], ['through', 'Camera’s eye', 'Eye', 'E']];

function icon(name) {
  const svg = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
  svg.setAttribute('viewBox', '0 0 24 24');
  svg.setAttribute('aria-hidden', 'true');
  const path = document.createElementNS('http://www.w3.org/2000/svg', 'path');
  path.setAttribute('d', ICONS[name]);
  if (name === 'start' || name === 'pause') path.setAttribute('class', 'solid');
  svg.append(path);
  return svg;
}

class Controls {
  constructor(page) {
    this.page = page;
    const button = (id, text, key, action) => {
      const node = element('button', { type: 'button', id, title: `${text} (${key})`, onclick: action }, icon(id === 'go' ? 'start' : id), element('span', {}, text));
      this[id] = node;
      return node;
    };
    byId('controls').append(
      button('undo', `Undo ${UNDO} s`, 'Z', () => this.undoLatest()),
      button('reset', 'Reset', 'R', () => this.askReset()),
      button('go', 'Start', 'Space', () => this.toggle()),
      button('crop', 'Crop', 'C', () => this.toggleCrop()),
      button('finish', 'Finish', 'Shift+Enter', () => this.askFinish()),
    );
    this.shadings = this.choice('shadings', SHADINGS, (name) => this.shade(name));
    this.modes = this.choice('modes', MODES, (name) => page.viewer.setMode(name));
    page.viewer.onMode = (mode) => this.mark(this.modes, mode);
    this.mark(this.modes, page.viewer.mode);
    this.mark(this.shadings, 'colour');
    addEventListener('keydown', (event) => this.key(event));
  }

  choice(id, entries, choose) {
    const buttons = entries.map(([name, text, short, key]) =>
      element('button', { type: 'button', 'data-name': name, title: `${text} (${key})`, 'aria-label': text, onclick: () => choose(name) }, element('span', { class: 'long' }, text), element('span', { class: 'short' }, short)));
    byId(id).append(...buttons);
    return buttons;
  }

  mark(buttons, name) {
    for (const button of buttons) button.setAttribute('aria-pressed', String(button.dataset.name === name));
  }

  shade(name) {
    this.page.viewer.surface.shade(name);
    this.page.viewer.paint();
    this.mark(this.shadings, name);
    byId('seen-legend').hidden = name !== 'seen';
  }

  setScene({ map }) {
    for (const id of ['undo', 'reset', 'crop']) this[id].hidden = map === false;
    this.go.hidden = map === false;
  }

  update({ phase, undo, undo_note, frames = 0 }) {
    const { surface } = this.page.viewer;
    if (surface.shading === 'colour' && !surface.hasColors) {
      this.shadings[0].hidden = true;
      this.shade('clay');
    }
    const key = JSON.stringify([phase, undo, undo_note, frames === 0]);
    if (key === this.shownFor) return;
    this.shownFor = key;
    this.phase = phase;
    const isRunning = phase === 'running';
    const isStanding = phase === 'paused' || phase === 'ready';
    if (this.goFor !== phase) {
      this.goFor = phase;
      const text = phase === 'ready' ? 'Start' : isRunning ? 'Pause' : 'Resume';
      this.go.replaceChildren(icon(isRunning ? 'pause' : 'start'), element('span', {}, text));
      this.go.title = `${text} (Space)`;
    }
    this.go.disabled = !(isRunning || isStanding);
    this.undo.disabled = !(isRunning || phase === 'paused') || !undo || frames === 0;
    if (undo_note) this.undo.title = undo_note;
    this.reset.disabled = !(isRunning || phase === 'paused') || frames === 0;
    this.crop.disabled = frames === 0 || !(isRunning || isStanding);
    this.finish.disabled = !(isRunning || isStanding);
  }

  toggle() {
    this.page.link.send(this.phase === 'running' ? 'pause' : this.phase === 'ready' ? 'start' : 'resume');
  }

  undoLatest() {
    this.page.link.send('undo', { seconds: UNDO });
  }

  toggleCrop() {
    const { crop, viewer, state } = this.page;
    if (crop.frame) return this.page.cropped(undefined);
    viewer.setMode('scene');
    crop.open(state.crop);
  }

  async askReset() {
    if (await ask('Begin anew? What was scanned so far is dropped.', 'Begin anew')) this.page.link.send('reset');
  }

  async askFinish() {
    const isRecording = this.page.scene?.map === false;
    if (await ask(isRecording ? 'End the recording?' : 'Finish, and save trajectory, mesh and report?', isRecording ? 'End it' : 'Finish and save')) this.page.link.send('finish');
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || byId('question').open) return;
    if (event.target.matches?.('input, select')) return;
    const press = (button) => !button.disabled && !button.hidden && button.click();
    const actions = {
      ' ': () => press(this.go), z: () => press(this.undo), r: () => press(this.reset), c: () => press(this.crop),
      Enter: () => event.shiftKey && press(this.finish), Escape: () => this.page.crop.frame && this.page.cropped(undefined),
    };
    for (const [list, entries] of [[this.shadings, SHADINGS], [this.modes, MODES]])
      entries.forEach(([, , , key], i) => (actions[key.toLowerCase()] = () => list[i].click()));
    const action = actions[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (!action || (event.key === 'Enter' && !event.shiftKey)) return;
    event.preventDefault(); // a focused button would be pressed too: the old one, or a question's
    action();
  }
}

/** Whether the user says yes. */
function ask(question, yes) {
  const dialog = byId('question');
  dialog.querySelector('p').textContent = question;
  return new Promise((resolve) => {
    const close = (answer) => {
      dialog.close();
      resolve(answer);
    };
    dialog.oncancel = () => resolve(false);
    dialog.querySelector('.row').replaceChildren(
      element('button', { type: 'button', class: 'primary', onclick: () => close(true) }, yes),
      element('button', { type: 'button', onclick: () => close(false) }, 'No'),
    );
    dialog.showModal();
  });
}

export function showControls(page) {
  return new Controls(page);
}
