// How far the pairs of one frame are apart, iteration by iteration: what --dump-icp wrote.
import uPlot from 'uplot';
import { element } from './dom.js';
import { axis } from './plots.js';
import { color, onThemeChange } from './theme.js';

const HEIGHT = 260;
const BINS = 120;

/** Distance within which all but a twentieth of the pairs lie, in the widest of the distributions; metres. */
function range(trace) {
  let widest = 0;
  for (const { histogram, pairs } of trace.iterations) {
    let count = 0, bin = 0;
    while (bin < histogram.length - 1 && count < 0.95 * pairs) count += histogram[bin++];
    widest = Math.max(widest, bin);
  }
  return Math.max(widest, 10) * trace.bin_width_m;
}

/** Share of the pairs per millimetre, %, over the distances of `x`. */
function densities(trace, each, bins) {
  return trace.iterations.map(({ histogram, pairs }) => {
    const millimetres = each * trace.bin_width_m * 1e3;
    return Array.from({ length: bins }, (_, i) => {
      let count = 0;
      for (let k = i * each; k < Math.min((i + 1) * each, histogram.length - 1); k++) count += histogram[k];
      return (100 * count) / Math.max(1, pairs) / millimetres;
    });
  });
}

const norm = (v) => Math.hypot(...v);
const columns = [
  ['Level', (i) => i.level],
  ['Median', (i) => `${(1e3 * i.median_distance_m).toFixed(2)} mm`],
  ['Pairs', (i) => i.pairs.toLocaleString('en')],
  ['Matched', (i) => `${(100 * i.matched_fraction).toFixed(1)} %`],
  ['Residual', (i) => `${(1e3 * i.rms_m).toFixed(2)} mm`],
  ['Turn', (i) => `${((180 / Math.PI) * norm(i.step_rotation_rad)).toFixed(3)}°`],
  ['Shift', (i) => `${(1e3 * norm(i.step_translation_m)).toFixed(2)} mm`],
];

/** One line an iteration, later ones darker; the chosen one stands out, with its median. */
class DistributionPlot {
  constructor(host, trace) {
    this.trace = trace;
    this.chosen = trace.iterations.length - 1;
    const within = range(trace);
    const each = Math.max(1, Math.ceil(within / trace.bin_width_m / BINS));
    const bins = Math.max(2, Math.ceil(within / trace.bin_width_m / each));
    const x = Array.from({ length: bins }, (_, i) => (i + 0.5) * each * trace.bin_width_m * 1e3);
    this.chart = new uPlot(this.options(), [x, ...densities(trace, each, bins)], host);
    this.resize = new ResizeObserver(() => this.chart.setSize({ width: host.clientWidth, height: HEIGHT }));
    this.resize.observe(host);
  }

  options() {
    const count = this.trace.iterations.length;
    const stroke = (i) => () => {
      if (i === this.chosen) return color('line-1');
      const share = count > 1 ? i / (count - 1) : 1;
      return `color-mix(in srgb, ${color('line-2')} ${Math.round(30 + 70 * share)}%, ${color('panel')})`;
    };
    return {
      width: 300,
      height: HEIGHT,
      legend: { show: false },
      cursor: { drag: { x: false, y: false }, points: { show: false } },
      scales: { x: { time: false }, y: { range: (_, low, high) => [0, high > 0 ? 1.08 * high : 1] } },
      axes: [
        axis({ label: 'distance of a pair, mm', labelSize: 18, labelFont: '11px system-ui, sans-serif', size: 24 }),
        axis({ label: 'share of the pairs per mm, %', labelSize: 18, labelFont: '11px system-ui, sans-serif', size: 40 }),
      ],
      series: [{}, ...this.trace.iterations.map((_, i) => ({ stroke: stroke(i), width: this.width(i), points: { show: false } }))],
      hooks: { draw: [(u) => this.drawMedian(u)] },
    };
  }

  drawMedian({ ctx, bbox, valToPos }) {
    const x = valToPos(1e3 * this.trace.iterations[this.chosen].median_distance_m, 'x', true);
    if (!(x >= bbox.left && x <= bbox.left + bbox.width)) return;
    ctx.save();
    ctx.strokeStyle = color('line-1');
    ctx.setLineDash([4 * devicePixelRatio, 3 * devicePixelRatio]);
    ctx.lineWidth = devicePixelRatio;
    ctx.beginPath();
    ctx.moveTo(x, bbox.top);
    ctx.lineTo(x, bbox.top + bbox.height);
    ctx.stroke();
    ctx.restore();
  }

  width(iteration) {
    return iteration === this.chosen ? 2.5 : 1.25;
  }

  choose(iteration) {
    this.chosen = iteration;
    this.chart.series.slice(1).forEach((series, i) => {
      series.width = this.width(i);
    });
    this.chart.redraw();
  }

  destroy() {
    this.resize.disconnect();
    this.chart.destroy();
  }
}

function table(trace, plot) {
  const rows = trace.iterations.map((iteration, i) => {
    const radio = element('input', { type: 'radio', name: 'iteration', 'aria-label': `Iteration ${i + 1}`, onchange: () => plot.choose(i) });
    radio.checked = i === plot.chosen;
    return element('tr', { onclick: () => radio.click() }, element('td', {}, element('label', {}, radio, `${i + 1}`)),
      ...columns.map(([, text]) => element('td', {}, `${text(iteration)}`)));
  });
  return element('div', { class: 'scroll' }, element('table', {},
    element('thead', {}, element('tr', {}, ...['Iteration', ...columns.map(([name]) => name)].map((name) => element('th', { scope: 'col' }, name)))),
    element('tbody', {}, ...rows)));
}

export function showDistribution(host, report) {
  const traces = (report.icp ?? []).filter((trace) => trace.iterations.length > 0);
  if (traces.length === 0) return null;
  host.hidden = false;
  const chart = element('div', { class: 'chart' });
  const rows = element('div');
  const state = { plot: null };
  const show = (trace) => {
    state.plot?.destroy();
    chart.replaceChildren();
    state.plot = new DistributionPlot(chart, trace);
    rows.replaceChildren(table(trace, state.plot));
  };
  const choice = traces.length === 1
    ? `Frame ${traces[0].frame}`
    : element('select', { 'aria-label': 'Frame', onchange: (event) => show(traces[event.target.selectedIndex]) },
      ...traces.map((trace) => element('option', {}, `Frame ${trace.frame}`)));
  host.append(element('h2', {}, 'Distances over the iterations', element('span', { class: 'choice' }, choice)),
    element('p', {}, 'How far the pairs of live and predicted points are apart, from the first iteration (pale) to the last. The dashed line is the median of the chosen one.'),
    element('div', { class: 'columns' }, chart, rows));
  onThemeChange(() => state.plot.chart.redraw());
  show(traces[0]);
  return state;
}
