/* The view in a notebook: it follows the model that the kernel holds, and tells it of clicks and turns. */
import {SliderNames} from './names.js';
import {View} from './view.js';

/* Milliseconds between two messages about the camera. */
const PAUSE = 60;

export function render({model, el}) {
  let end;
  const anew = () => {
    end?.();
    end = begun(model, el, anew);
  };
  anew();
  const names = new SliderNames(el);
  return () => {
    names.dispose();
    end?.();
  };
}

/* A view that follows the model; what ends it, or nothing where it cannot be. `again` is asked for one in its place. */
function begun(model, el, again) {
  const view = started(model, el, again);
  if (!view) return undefined;
  const followed = [];
  const follow = (name, act) => {
    const changed = () => {
      try {
        act(model.get(name));
      } catch (error) {
        tell(el, error);
      }
    };
    model.on(`change:${name}`, changed);
    followed.push([`change:${name}`, changed]);
    changed();
  };
  follow('paints', (paints) => paints.forEach((paint, i) => view.paint(i, paint)));
  follow('marks', (marks) => marks.forEach((each, i) => view.setMarks(i, each)));
  follow('lines', (lines) => lines.forEach((each, i) => view.setLines(i, each)));
  follow('texture', (texture) => { view.setTexture(texture).catch((error) => tell(el, error)); });
  follow('legend', (legend) => { view.legend = legend; });
  follow('brush', (brush) => { view.brush = brush; });
  follow('look', (look) => view.setLook(look));
  follow('tick', (tick) => view.showTime(timeAt(tick, model.get('ticks'), view.frames)));
  follow('camera', (camera) => {
    if (camera.position && JSON.stringify(camera) !== JSON.stringify(view.orbit.state)) view.setCamera(camera);
  });
  return () => {
    for (const [event, changed] of followed) model.off(event, changed);
    view.dispose();
  };
}

/* The view, or a still picture where nothing can be drawn. */
function started(model, el, again) {
  let waiting = 0;
  const told = (state) => {
    model.set('camera', state);
    waiting ||= setTimeout(() => {
      waiting = 0;
      model.save_changes();
    }, PAUSE);
  };
  try {
    return new View(el, model.get('setup'), {
      pick: (pane, {corners, point}) => model.send({kind: 'pick', pane, corners, point}),
      paint: (pane, {corners, point}) => model.send({kind: 'paint', pane, corners, point}),
      camera: told,
      again,
      look: (look) => {
        model.set('look', look);
        model.save_changes();
      },
    });
  } catch (error) {
    showStills(model, el, error);
    return null;
  }
}

/* What could not be shown, as a sentence above all else. */
function tell(el, error) {
  const sentence = document.createElement('p');
  sentence.setAttribute('role', 'alert');
  sentence.textContent = `The browser could not show this: ${error.message}`;
  el.prepend(sentence);
}

function showStills(model, el, error) {
  const sentence = document.createElement('p');
  sentence.setAttribute('role', 'alert');
  const webgl = document.createElement('canvas').getContext('webgl2');
  const why = webgl ? `The shapes could not be drawn (${error.message})` : 'This browser shows no WebGL';
  sentence.textContent = `${why}, so this is a still picture. The controls work; then draw it anew.`;
  const again = document.createElement('button');
  again.textContent = 'draw anew';
  again.addEventListener('click', () => model.send({kind: 'redraw'}));
  const pictures = document.createElement('div');
  const show = () => pictures.replaceChildren(...model.get('stills').map((url) => {
    const image = document.createElement('img');
    image.alt = 'the shape, drawn in software';
    image.src = url;
    return image;
  }));
  model.on('change:stills', show);
  show();
  el.classList.add('qgeo-stills');
  el.replaceChildren(sentence, again, pictures);
}

/* Time of a clock that runs from 0 to `ticks`, and as far again on its way back. */
function timeAt(tick, ticks, times) {
  if (!times) return 0;
  const there = tick > ticks ? 2 - tick / ticks : tick / ticks;
  return times[0] + there * (times[times.length - 1] - times[0]);
}
