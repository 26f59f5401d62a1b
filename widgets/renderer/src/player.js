/* The time of shapes in motion on a page: its slider, play and pause, speed, and what happens at the end. */

export class Player {
  /* `show(time)` draws the shapes at a time. */
  constructor(motion, show) {
    const element = (id) => document.getElementById(id);
    this.times = motion.times;
    this.seconds = motion.seconds;
    this.show = show;
    this.first = this.times[0];
    this.last = this.times[this.times.length - 1];
    this.playing = false;
    this.direction = 1;
    [this.button, this.slider, this.value, this.loop] = ['play', 'time', 'time-value', 'loop'].map(element);
    this.digits = Math.min(Math.max(2 - Math.floor(Math.log10(this.last - this.first || 1)), 0), 6);
    this.slider.min = this.first;
    this.slider.max = this.last;
    this.loop.value = motion.loop;
    const speed = element('speed');
    speed.min = Math.log10(0.05);
    speed.max = Math.log10(20);
    speed.value = Math.log10(motion.speed);
    const speedSet = () => {
      this.speed = Math.pow(10, Number(speed.value));
      element('speed-value').textContent = `${this.speed.toFixed(2)}×`;
    };
    speed.addEventListener('input', speedSet);
    this.slider.addEventListener('input', () => this.goTo(Number(this.slider.value)));
    this.button.addEventListener('click', () => (this.playing ? this.pause() : this.play()));
    element('player').hidden = this.times.length < 2;
    speedSet();
    this.goTo(motion.time);
  }

  goTo(time) {
    this.time = Math.min(Math.max(time, this.first), this.last);
    this.show(this.time);
    this.slider.value = this.time;
    this.value.textContent = this.time.toFixed(this.digits);
  }

  play() {
    if (this.loop.value !== 'back and forth') this.direction = 1;
    if (this.direction > 0 && this.time >= this.last && this.loop.value !== 'back and forth') this.time = this.first;
    this.playing = true;
    this.button.textContent = 'pause';
    this.drawn = null;
    requestAnimationFrame((now) => this.tick(now));
  }

  pause() {
    this.playing = false;
    this.button.textContent = 'play';
  }

  tick(now) {
    if (!this.playing) return;
    const span = this.last - this.first;
    const passed = this.drawn === null ? 0 : (now - this.drawn) / 1000;
    this.drawn = now;
    if (this.loop.value !== 'back and forth') this.direction = 1;
    let time = this.time + this.direction * span * this.speed * passed / this.seconds;
    if (time > this.last || time < this.first) {
      if (this.loop.value === 'repeat') {
        time = this.first + (time - this.first) % span;
      } else if (this.loop.value === 'once') {
        this.pause();
      } else {
        this.direction = time > this.last ? -1 : 1;
      }
    }
    this.goTo(time);
    if (this.playing) requestAnimationFrame((next) => this.tick(next));
  }
}
