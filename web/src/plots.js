// Figures over the frames. A drag over any of them moves the frame for all.
import uPlot from 'uplot';
import { element, figure } from './dom.js';
import { color, onThemeChange } from './theme.js';

const HEIGHT = 118;
const STAGES = ['preprocess', 'track', 'integrate', 'raycast'];

const scaled = (column, factor) => Array.from(column, (value) => (Number.isFinite(value) ? factor * value : null));

/** What is drawn: a title, and lines with name, values over the rows, colour, unit. */
function plotList(frames) {
  const line = (name, column, factor, paint, digits, unit, more = {}) => ({ name, values: scaled(frames.column(column), factor), paint, digits, unit, ...more });
  const list = [];
  if (frames.has('error_m'))
    list.push({ title: 'Distance from the true path', lines: [line('', 'error_m', 1e3, 'difference', 1, 'mm')] });
  list.push(
    { title: 'Median distance of the pairs', lines: [line('', 'median_distance_m', 1e3, 'line-1', 1, 'mm')] },
    { title: 'Matched pixels', lines: [line('', 'inlier_fraction', 100, 'line-1', 0, '%')] },
    { title: 'Iterations', lines: [line('', 'iterations', 1, 'line-1', 0, '', { stepped: true })] },
    {
      title: 'Turn',
      lines: [
        line('previous pose to guess', 'seed_deg', 1, 'line-2', 2, '°'),
        line('guess to result', 'seed_to_result_deg', 1, 'line-1', 2, '°'),
      ],
    },
    {
      title: 'Time of the stages, ms',
      stacked: true,
      lines: STAGES.map((stage, i) => line(stage === 'raycast' ? 'ray cast' : stage, `${stage}_ms`, 1, `stage-${i + 1}`, 1, '')),
    },
  );
  return list;
}

/** Each line on top of those before it. */
function stack(lines) {
  const sums = new Array(lines[0].values.length).fill(0);
  return lines.map(({ values }) => values.map((value, i) => (sums[i] += value ?? 0)));
}

/** Bands where frames were lost, below the lines. */
function drawLost(plot, lost) {
  const { ctx, bbox } = plot;
  ctx.save();
  ctx.fillStyle = color('lost-band');
  for (const [from, to] of lost) {
    const left = plot.valToPos(from - 0.5, 'x', true);
    ctx.fillRect(left, bbox.top, Math.max(devicePixelRatio, plot.valToPos(to + 0.5, 'x', true) - left), bbox.height);
  }
  ctx.restore();
}

function drawCursor(plot, x) {
  const { ctx, bbox } = plot;
  const left = Math.round(plot.valToPos(x, 'x', true));
  ctx.save();
  ctx.fillStyle = color('text');
  ctx.fillRect(left - devicePixelRatio / 2, bbox.top, devicePixelRatio, bbox.height);
  ctx.restore();
}

/** Stretches of lost frames as [first, last] of the plots' x. */
function lostStretches(frames, lostStatus) {
  const status = frames.column('status');
  const x = frames.column('index');
  const stretches = [];
  for (let row = 0; row < frames.rows; row++) {
    if (status[row] !== lostStatus) continue;
    if (row > 0 && status[row - 1] === lostStatus) stretches.at(-1)[1] = x[row];
    else stretches.push([x[row], x[row]]);
  }
  return stretches;
}

export function axis(more = {}) {
  return {
    stroke: () => color('muted'),
    grid: { stroke: () => color('grid'), width: 1 },
    ticks: { show: false },
    font: '11px system-ui, sans-serif',
    ...more,
  };
}

function options(plot, lost, current) {
  const series = plot.lines.map(({ paint, stepped }) => ({
    stroke: () => color(paint),
    width: plot.stacked ? 0 : 1.5,
    fill: plot.stacked ? () => color(paint) : undefined,
    paths: stepped ? uPlot.paths.stepped({ align: 1 }) : undefined,
    points: { show: false },
  }));
  return {
    width: 300,
    height: HEIGHT,
    legend: { show: false },
    padding: [6, 6, 0, 0],
    cursor: { drag: { x: false, y: false }, points: { show: false }, y: false },
    scales: {
      x: { time: false },
      y: { range: (_, low, high) => [Math.min(0, low ?? 0), high > 0 ? 1.08 * high : 1] },
    },
    axes: [axis({ size: 22, gap: 2 }), axis({ size: 40, gap: 4, space: 28 })],
    series: [{}, ...(plot.stacked ? series.reverse() : series)],
    hooks: { drawClear: [(u) => drawLost(u, lost)], draw: [(u) => drawCursor(u, current())] },
  };
}

/** Pressing and dragging sets the frame. */
function scrub(chart, cursor) {
  const move = (event) => {
    const { left } = chart.over.getBoundingClientRect();
    cursor.go(chart.valToIdx(chart.posToVal(event.clientX - left, 'x')));
  };
  chart.over.addEventListener('pointerdown', (event) => {
    chart.over.setPointerCapture(event.pointerId);
    move(event);
  });
  chart.over.addEventListener('pointermove', (event) => {
    if (event.buttons & 1) move(event);
  });
}

function addPlot(host, plot, x, lost, cursor) {
  const values = plot.lines.map(({ name, paint }) =>
    element('span', { class: 'value' }, name ? element('i', { style: `background:var(--${paint})` }) : null, name ? `${name} ` : null, element('b')));
  const body = element('div', { class: 'chart' });
  host.append(element('figure', {}, element('figcaption', {}, element('span', {}, plot.title), element('span', { class: 'values' }, ...values)), body));
  const lines = plot.stacked ? stack(plot.lines).reverse() : plot.lines.map((line) => line.values);
  const chart = new uPlot(options(plot, lost, () => x[cursor.row]), [x, ...lines], body);
  new ResizeObserver(() => chart.setSize({ width: body.clientWidth, height: HEIGHT })).observe(body);
  onThemeChange(() => chart.redraw());
  scrub(chart, cursor);
  cursor.onChange((row) => {
    plot.lines.forEach((line, i) => {
      values[i].lastChild.textContent = figure(line.values[row] ?? NaN, line.digits, line.unit);
    });
    chart.redraw(false);
  });
  return chart;
}

export function showPlots(host, report, cursor) {
  const { frames } = report;
  host.hidden = false;
  const x = Array.from(frames.column('index'));
  const lost = lostStretches(frames, report.names.status.indexOf('lost'));
  const charts = plotList(frames).map((plot) => addPlot(host, plot, x, lost, cursor));
  if (frames.stride > 1) host.append(element('p', { class: 'note' }, `A long run: every ${frames.stride}th frame is shown. frames.csv has all of them.`));
  return charts;
}
