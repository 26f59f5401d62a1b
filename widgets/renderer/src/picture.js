/* A picture as SVG: shapes as pixels, titles and legend as text and lines. */

const SVG = 'http://www.w3.org/2000/svg';

/* `png` covers a box [width, height], of which so much is shown; `captions` are {text, x, y}, `legend` is SVG. */
export async function withLegend(png, [width, height], shown, captions, legend, transparent) {
  const key = legend ? new DOMParser().parseFromString(legend, 'image/svg+xml').documentElement : null;
  const [wide, high] = key ? [key.width.baseVal.value, key.height.baseVal.value] : [0, 0];
  const [across, down] = [Math.max(width, wide), shown + high];
  const root = element('svg', {width: across, height: down, viewBox: `0 0 ${across} ${down}`});
  if (!transparent) root.append(element('rect', {width: across, height: down, fill: '#ffffff'}));
  const left = (across - width) / 2;
  const frame = element('svg', {x: left, y: 0, width, height: shown, viewBox: `0 0 ${width} ${shown}`});
  const words = {'font-family': 'sans-serif', 'font-size': 13, fill: '#1d2026'};
  frame.append(element('image', {width, height, href: await dataUrl(png)}));
  for (const {text, x, y} of captions) {
    const title = element('text', {...words, x, y});
    title.textContent = text;
    frame.append(title);
  }
  root.append(frame);
  if (key) {
    key.setAttribute('x', (across - wide) / 2);
    key.setAttribute('y', shown);
    root.append(document.importNode(key, true));
  }
  return new Blob([new XMLSerializer().serializeToString(root)], {type: 'image/svg+xml'});
}

function element(name, attributes) {
  const each = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) each.setAttribute(key, value);
  return each;
}

function dataUrl(blob) {
  return new Promise((done, failed) => {
    const reader = new FileReader();
    reader.onload = () => done(reader.result);
    reader.onerror = () => failed(reader.error);
    reader.readAsDataURL(blob);
  });
}
