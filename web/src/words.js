// The parts of the page that are text.
import { byId, element } from './dom.js';

function addFacts(list, facts) {
  for (const { label, value, note } of facts)
    list.append(element('div', {}, element('dt', {}, label), element('dd', {}, value, note ? element('small', {}, note) : null)));
}

/** TOML with its comments set back. */
function configText(toml) {
  return toml.split('\n').flatMap((line) => {
    const [, code, comment] = line.match(/^((?:[^"#]|"[^"]*")*)(#.*)?$/) ?? [null, line, ''];
    const kind = code.startsWith('[') ? 'b' : 'span';
    return [element(kind, {}, code), comment ? element('i', {}, comment) : '', '\n'];
  });
}

export function showWords(report) {
  document.title = `${report.title} – Plumbline`;
  byId('title').append(report.title);
  byId('verdict').append(report.verdict.text);
  byId('verdict').dataset.level = report.verdict.level;
  byId('verdict').hidden = !report.verdict.text;
  byId('remarks').append(...report.remarks.map((text) => element('p', {}, text)));
  addFacts(byId('facts'), report.facts);
  byId('details').hidden = report.details.length === 0;
  if (!report.frames) byId('details').querySelector('h2').textContent = 'This mesh';
  addFacts(byId('detail-list'), report.details);
  if (report.config) {
    byId('config').hidden = false;
    byId('config-text').append(...configText(report.config));
  }
  byId('footer').append(`Plumbline ${report.plumbline}, three.js ${VERSIONS.three}, uPlot ${VERSIONS.uPlot}. This page needs no network.`);
}
