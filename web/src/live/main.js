// The live page: what the program sends, and what one can ask it for.
import '../style.css';
import './live.css';
import { decoderReady } from '../decode.js';
import { byId } from '../dom.js';
import { showControls } from './controls.js';
import { CropBox, planesOf } from './crop.js';
import { Link } from './link.js';
import { LiveViewer } from './viewer.js';
import { Words } from './words.js';
import { Pictures } from './pictures.js';

const KEPT = 2000; // latencies
const INTERVAL = 45; // milliseconds from update to update, where the processor draws

function keep(latencies, value) {
  latencies.push(value);
  if (latencies.length > KEPT) latencies.shift();
}

class Page {
  constructor() {
    this.state = {};
    this.scene = null;
    // Of each new frame: from its coming out of the camera until pose, picture and surface are drawn and the browser has
    // begun its next picture; and of each new part of the surface, from the frame that brought it. Milliseconds.
    this.latencies = [];
    this.surfaceLatencies = [];
    this.unshown = 0; // updates that came and are not drawn yet
    this.maxUnshown = 0;
    this.fresh = []; // stamps of what is new in the surface
    this.viewer = new LiveViewer(byId('scene'));
    this.words = new Words();
    this.pictures = new Pictures();
    this.crop = new CropBox(this.viewer, byId('crop-panel'), { onDone: (box) => this.cropped(box) });
    this.link = new Link({ receive: (message) => this.receive(message), onChange: (isOpen) => this.connected(isOpen) });
    this.controls = showControls(this);
  }

  connected(isOpen) {
    this.isOpen = isOpen;
    if (!isOpen) this.words.curtain(this.isOver ? null : { title: 'The program does not answer', text: 'The page goes on by itself once it does.' });
    else this.words.curtain(null);
  }

  receive(message) {
    if (message.type === 'scene') this.begin(message);
    else if (message.type === 'surface' && message.epoch === this.scene?.epoch) this.addSurface(message);
    else if (message.type === 'picture') this.pictures.show(message);
    else if (message.type === 'state') this.update(message);
  }

  begin(scene) {
    this.scene = scene;
    this.shown = null;
    this.viewer.setScene(scene);
    this.pictures.forget();
    this.words.setScene(scene);
    this.controls.setScene(scene);
  }

  addSurface(message) {
    this.viewer.surface.set(message);
    if (message.stamp) this.fresh.push(message.stamp);
  }

  update(state) {
    this.state = state;
    const { frame } = state;
    const isNew = frame && frame.index !== this.shown;
    if (!frame) this.pictures.setLost((this.isLost = false));
    if (frame) {
      this.isLost = frame.status === 'lost' || frame.status === 'provisional';
      this.viewer.setPose(frame.pose, this.isLost, isNew);
      this.pictures.setLost(this.isLost);
    }
    if (state.up) this.viewer.setGravity(state.up);
    if (JSON.stringify(state.crop ?? null) !== this.cropText) {
      this.cropText = JSON.stringify(state.crop ?? null);
      if (!this.crop.frame) this.viewer.surface.clip(planesOf(state.crop));
    }
    this.words.update(state, this);
    this.controls.update(state);
    this.drawn(state.number, isNew ? frame : null);
    if (state.phase === 'finished' || state.phase === 'failed') this.finish(state);
  }

  /** Tells the program when this update is drawn, pictures included. */
  drawn(number, frame) {
    if (frame) this.shown = frame.index;
    const stamps = this.fresh.splice(0);
    this.maxUnshown = Math.max(this.maxUnshown, ++this.unshown);
    const isDrawn = this.viewer.renderer ? new Promise((resolve) => this.viewer.show(resolve)) : Promise.resolve();
    Promise.all([isDrawn, this.pictures.ready]).then(() => {
      this.unshown--;
      this.tell(number);
      requestAnimationFrame(() => {
        const now = performance.timeOrigin + performance.now();
        if (frame) keep(this.latencies, now - frame.stamp);
        for (const stamp of stamps) keep(this.surfaceLatencies, now - stamp);
      });
    });
  }

  /** Where the processor draws, it is left some time for the surface. */
  tell(number) {
    const wait = this.viewer.isSlow ? Math.max(0, (this.toldAt ?? 0) + INTERVAL - performance.now()) : 0;
    this.toldAt = performance.now() + wait;
    if (wait) setTimeout(() => this.link.send('shown', { number }), wait);
    else this.link.send('shown', { number });
  }

  cropped(box) {
    if (box !== undefined) this.link.send('crop', box ? { box } : {});
    this.crop.close();
    this.viewer.surface.clip(planesOf(box === undefined ? this.state.crop : box));
    this.viewer.render();
  }

  /** The page becomes the report. */
  finish(state) {
    if (this.isOver) return;
    this.isOver = true;
    if (state.phase === 'finished' && !state.note) location.replace(`report.html${location.search}`);
    else this.link.close();
  }
}

decoderReady.then(() => {
  window.plumbline = new Page(); // for the console, and for tests
});
