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

class Page {
  constructor() {
    this.state = {};
    this.scene = null;
    this.latencies = []; // milliseconds from the camera's frame to its picture here
    this.updates = 0;
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
    else if (message.type === 'surface' && message.epoch === this.scene?.epoch) this.viewer.surface.set(message);
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

  /** Tells the program when the picture with this update is on the screen. */
  drawn(number, frame) {
    const tell = () => {
      this.updates++;
      this.link.send('shown', { number });
      if (!frame) return;
      this.shown = frame.index;
      this.latencies.push(performance.timeOrigin + performance.now() - frame.stamp);
      if (this.latencies.length > KEPT) this.latencies.shift();
    };
    if (!this.viewer.renderer) return tell();
    this.viewer.onDraw.push(tell);
    this.viewer.render();
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
