/** An element with attributes and children: strings become text, never markup. */
export function element(tag, attributes = {}, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === false || value === undefined) continue;
    if (name.startsWith('on')) node.addEventListener(name.slice(2), value);
    else node.setAttribute(name, value === true ? '' : value);
  }
  node.append(...children.filter((child) => child !== null && child !== undefined));
  return node;
}

export const byId = (id) => document.getElementById(id);

/** A number with few digits, or a dash for what is not known. */
export function figure(value, digits, unit) {
  return Number.isFinite(value) ? `${value.toFixed(digits)}${unit && unit !== '°' ? '\u202f' : ''}${unit}` : '–';
}
