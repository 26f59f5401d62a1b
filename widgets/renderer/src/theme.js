/* Tells when the page becomes dark or light: JupyterLab, VS Code and Colab say so in attributes, others by the system. */

const NAMES = ['data-jp-theme-light', 'class', 'theme'];

export class ThemeWatch {
  constructor(changed) {
    this.changed = changed;
    this.observer = new MutationObserver(changed);
    for (const each of [document.documentElement, document.body]) {
      this.observer.observe(each, {attributes: true, attributeFilter: NAMES});
    }
    this.system = matchMedia('(prefers-color-scheme: dark)');
    this.system.addEventListener('change', changed);
  }

  dispose() {
    this.observer.disconnect();
    this.system.removeEventListener('change', this.changed);
  }
}
