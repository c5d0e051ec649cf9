// What the camera sees, and what it saw before it was lost.
import { byId } from '../dom.js';

export class Pictures {
  constructor() {
    this.urls = {};
    this.counts = { color: 0, depth: 0, good: 0 };
  }

  show({ kind, buffers }) {
    const figure = byId(kind);
    if (!figure) return;
    const image = figure.querySelector('img');
    const url = URL.createObjectURL(new Blob([buffers.jpeg], { type: 'image/jpeg' }));
    image.onload = () => {
      if (this.urls[kind]) URL.revokeObjectURL(this.urls[kind]);
      this.urls[kind] = url;
    };
    image.src = url;
    this.counts[kind]++;
    if (kind !== 'good') figure.hidden = false;
    else this.hasGood = true;
    this.arrange();
  }

  /** Of a run that begins anew. */
  forget() {
    this.hasGood = false;
    this.arrange();
  }

  setLost(isLost) {
    this.isLost = isLost;
    this.arrange();
  }

  arrange() {
    byId('good').hidden = !(this.isLost && this.hasGood);
    byId('pictures').classList.toggle('lost', Boolean(this.isLost));
  }
}
