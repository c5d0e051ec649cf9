// The report: text, 3D view, time line and plots around one number, the current frame's row.
import 'uplot/dist/uPlot.min.css';
import './style.css';
import { readReport } from './data.js';
import { byId } from './dom.js';
import { showDistribution } from './distribution.js';
import { showPlots } from './plots.js';
import { showTimeline } from './timeline.js';
import { Viewer } from './viewer.js';
import { showWords } from './words.js';

/** The row that everything shows. */
class Cursor {
  constructor(rows) {
    this.rows = rows;
    this.row = 0;
    this.listeners = [];
  }

  onChange(listener) {
    this.listeners.push(listener);
  }

  go(row) {
    this.row = Math.min(Math.max(0, Math.round(row)), this.rows - 1);
    for (const listener of this.listeners) listener(this.row);
  }
}

async function start() {
  const report = await readReport();
  showWords(report);
  const cursor = new Cursor(report.frames?.rows ?? 0);
  const viewer = new Viewer(byId('scene'), byId('layers'), report);
  document.body.classList.toggle('mesh-only', !report.frames);
  let plots = [], distribution = null;
  if (report.frames) {
    showTimeline(report, cursor);
    plots = showPlots(byId('plots'), report, cursor);
    distribution = showDistribution(byId('distribution'), report);
    cursor.onChange((row) => viewer.showFrame(row));
    cursor.go(0);
  }
  window.plumbline = { report, cursor, viewer, plots, distribution }; // for the console, and for tests
}

start().catch((error) => {
  byId('verdict').textContent = `The page could not be built: ${error.message}`;
  byId('verdict').dataset.level = 'poor';
  throw error;
});
