// Colours live in style.css; canvases ask for them here, again when the system turns dark or light.
const dark = matchMedia('(prefers-color-scheme: dark)');

export function color(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}

export function onThemeChange(action) {
  dark.addEventListener('change', action);
}
