/* A page that cannot draw says so, with the error and the still picture: nobody has to guess at an empty page. */
'use strict';

const drawsNothing = (sentence) => {
  document.getElementById('why').textContent = sentence;
  document.getElementById('no-drawing').hidden = false;
  for (const id of ['controls', 'shapes', 'player']) document.getElementById(id).hidden = true;
};

const drawsNoShapes = (error) => {
  const webgl = document.createElement('canvas').getContext('webgl2');
  drawsNothing(webgl
    ? `This page could not draw the shapes, so this is a still picture. The error was: ${error.name}: ${error.message}`
    : 'This browser shows no WebGL, so this is a still picture.');
};

window.addEventListener('unhandledrejection', (event) => drawsNoShapes(event.reason));
window.addEventListener('error', (event) => drawsNoShapes(event.error ?? {name: 'Error', message: event.message}));
