/* Names for screen readers of the sliders beside a view: those of ipywidgets have handles without any. */

export class SliderNames {
  constructor(el) {
    this.observer = new MutationObserver(() => this.#name());
    const attached = () => {
      if (!el.isConnected) {
        this.waiting = requestAnimationFrame(attached);
        return;
      }
      this.cell = el.closest('.jp-OutputArea-output') ?? el.parentElement;
      this.observer.observe(this.cell, {childList: true, subtree: true});
      this.#name();
    };
    attached();
  }

  dispose() {
    cancelAnimationFrame(this.waiting);
    this.observer.disconnect();
  }

  #name() {
    for (const slider of this.cell.querySelectorAll('.widget-slider')) {
      const label = slider.querySelector('.widget-label');
      const name = label?.textContent || label?.title || slider.title;
      const handles = slider.querySelectorAll('.noUi-handle');
      const ends = handles.length > 1 ? [', from', ', to'] : [''];
      handles.forEach((handle, i) => handle.setAttribute('aria-label', `${name}${ends[i] ?? ''}`));
    }
  }
}
