/* The panel of how shapes are drawn: edges, shading, opacity, light, background, projection, standard views, pictures. */

export const LOOK = {edges: false, flat: false, orthographic: false, opacity: 1, light: 1, background: 'theme'};

const CHECKS = {edges: 'edges', flat: 'flat shading', orthographic: 'parallel projection'};
const SLIDERS = {opacity: ['opacity', 0.1, 1], light: ['light', 0.3, 1.7]};
const GROUNDS = {theme: 'as the page', '#ffffff': 'white', '#7f7f7f': 'grey', '#000000': 'black'};
/* Turns of the first view about the vertical axis, or over the top, in degrees. */
const SIDES = {
  'first view': [0, 0], 'from behind': [180, 0], 'from the left': [-90, 0], 'from the right': [90, 0],
  'from above': [0, 90], 'from below': [0, -90],
};

export class LookPanel {
  constructor(view) {
    this.view = view;
    this.state = {...LOOK};
    this.inputs = {};
    this.element = document.createElement('details');
    this.element.className = 'qgeo-look';
    const summary = document.createElement('summary');
    summary.textContent = 'view and picture';
    this.element.append(summary, this.#controls());
    this.saved = [];
  }

  /* Make the controls say what is shown. */
  show(state) {
    this.state = state;
    for (const [name, input] of Object.entries(this.inputs)) {
      if (input.type === 'checkbox') input.checked = state[name];
      else input.value = state[name];
    }
  }

  #controls() {
    const row = document.createElement('div');
    for (const [name, label] of Object.entries(CHECKS)) {
      const input = this.#input(name, 'checkbox', (each) => each.checked);
      row.append(labelled(input, label, false));
    }
    for (const [name, [label, min, max]] of Object.entries(SLIDERS)) {
      const input = this.#input(name, 'range', (each) => Number(each.value));
      Object.assign(input, {min, max, step: 0.05, value: this.state[name]});
      row.append(labelled(input, label, true));
    }
    const ground = choice(GROUNDS);
    ground.addEventListener('change', () => this.#changed('background', ground.value));
    this.inputs.background = ground;
    row.append(labelled(ground, 'background', true), this.#views(), this.#picture());
    return row;
  }

  #input(name, type, read) {
    const input = document.createElement('input');
    input.type = type;
    input.addEventListener('input', () => this.#changed(name, read(input)));
    this.inputs[name] = input;
    return input;
  }

  #changed(name, value) {
    this.view.setLook({[name]: value});
    this.view.handlers.look?.(this.view.look);
  }

  /* Sides of the first view, and views that were saved here. */
  #views() {
    const group = document.createElement('span');
    const list = choice({'': 'go to …', ...Object.fromEntries(Object.keys(SIDES).map((side) => [side, side]))});
    list.addEventListener('change', () => {
      const saved = this.saved[Number(list.value.replace('saved ', '')) - 1];
      if (list.value in SIDES) this.#turn(...SIDES[list.value]);
      else if (saved) this.view.setCamera(saved);
      this.view.handlers.camera?.(this.view.orbit.state);
      list.value = '';
    });
    const keep = button('keep this view', () => {
      this.saved.push(this.view.orbit.state);
      const name = `saved ${this.saved.length}`;
      list.add(new Option(name, name));
    });
    group.append(labelled(list, 'look', true), keep);
    return group;
  }

  #turn(around, over) {
    const {orbit} = this.view;
    orbit.reset();
    orbit.turn(-around / 360, over / 360);
  }

  #picture() {
    const group = document.createElement('span');
    const size = choice({1: 'as on screen', 2: '2 times as large', 4: '4 times as large'});
    const form = choice({png: 'PNG', svg: 'SVG, with legend'});
    const clear = document.createElement('input');
    clear.type = 'checkbox';
    const save = button('save picture', async () => {
      const link = document.createElement('a');
      link.download = `qgeo-picture.${form.value}`;
      const made = form.value === 'svg' ? 'drawing' : 'picture';
      link.href = URL.createObjectURL(await this.view[made](Number(size.value), clear.checked));
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
    });
    group.append(labelled(size, 'picture', true), labelled(form, 'form', true), labelled(clear, 'no background', false), save);
    return group;
  }
}

function labelled(input, text, before) {
  const label = document.createElement('label');
  input.setAttribute('aria-label', text);  /* without the names of a list's entries */
  label.append(...(before ? [`${text} `, input] : [input, ` ${text}`]));
  return label;
}

function choice(options) {
  const list = document.createElement('select');
  for (const [value, text] of Object.entries(options)) list.add(new Option(text, value));
  return list;
}

function button(text, clicked) {
  const each = document.createElement('button');
  each.type = 'button';
  each.textContent = text;
  each.addEventListener('click', clicked);
  return each;
}
