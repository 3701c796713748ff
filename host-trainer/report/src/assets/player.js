// Plays episodes. The state of the first player stands on the document element as
// data-step, data-coverage and data-playing.
(() => {
  const root = document.documentElement;
  const still = matchMedia('(prefers-reduced-motion: reduce)');
  const players = [];
  let active = null;

  class Player {
    constructor(element) {
      this.element = element;
      this.episodes = JSON.parse(element.querySelector('script').textContent);
      this.canvas = element.querySelector('canvas');
      this.slider = element.querySelector('[data-slider]');
      this.speed = element.querySelector('[data-speed]');
      this.tip = element.querySelector('[data-tip]');
      this.t = 0;
      this.playing = false;
      this.selected = null;
      this.queued = false;
      this.readColours();
      this.listen();
      this.choose(0);
    }

    find(name) { return this.element.querySelector(`[data-show="${name}"]`); }
    curve(name) { return this.element.querySelector(`[data-curve="${name}"]`); }
    get last() { return this.episode.frames.length - 1; }
    get count() { return this.episode.frames[0].p.length / 2; }
    get step() { return Math.floor(this.t + 1e-9); }

    listen() {
      const on = (target, type, act) => target.addEventListener(type, act);
      const actions = { play: () => this.toggle(), back: () => this.go(this.step - 1), forward: () => this.go(this.step + 1) };
      for (const button of this.element.querySelectorAll('[data-do]')) on(button, 'click', actions[button.dataset.do]);
      for (const button of this.element.querySelectorAll('[data-episode]')) {
        on(button, 'click', () => this.choose(Number(button.dataset.episode)));
      }
      for (const layer of this.element.querySelectorAll('[data-layer]')) on(layer, 'change', () => this.redraw());
      on(this.slider, 'input', () => this.go(Number(this.slider.value)));
      on(this.element, 'pointerdown', () => { active = this; });
      on(this.element, 'focusin', () => { active = this; });
      on(this.element, 'keydown', (event) => this.key(event));
      on(this.canvas, 'pointermove', (event) => this.point(event));
      on(this.canvas, 'pointerdown', (event) => this.point(event));
      on(this.canvas, 'pointerleave', (event) => { if (event.pointerType === 'mouse') this.select(null); });
      const seek = this.element.querySelector('[data-seek]');
      const seekTo = (event) => {
        const box = seek.getBoundingClientRect();
        this.go(Math.round(((event.clientX - box.left) / box.width) * this.last));
      };
      on(seek, 'pointerdown', (event) => { seek.setPointerCapture(event.pointerId); seekTo(event); });
      on(seek, 'pointermove', (event) => { if (event.buttons) seekTo(event); });
      const recolour = () => { this.readColours(); this.redraw(); };
      on(globalThis, 'themechange', recolour);
      on(matchMedia('(prefers-color-scheme: dark)'), 'change', recolour);
      new ResizeObserver(() => this.redraw()).observe(this.canvas);
    }

    readColours() {
      const style = getComputedStyle(root);
      const names = ['map', 'grid', 'disc', 'edge', 'uav', 'covered', 'open'];
      this.colours = Object.fromEntries(names.map((name) => [name, style.getPropertyValue(`--${name}`).trim()]));
    }

    // Another episode, at the same step: so two policies can be compared.
    choose(index) {
      this.episode = this.episodes[index];
      for (const button of this.element.querySelectorAll('[data-episode]')) {
        button.setAttribute('aria-pressed', String(Number(button.dataset.episode) === index));
      }
      this.slider.max = String(this.last);
      this.find('last').textContent = String(this.last);
      this.find('half').textContent = String(this.last / 2);
      this.selected = null;
      // The index so far: mean over the states after a step; the spawn is not scored.
      let sum = 0;
      this.means = this.episode.frames.map((frame, k) => (k === 0 ? 0 : (sum += frame.v) / k));
      this.curve('now-all').setAttribute('d', this.path((k) => this.episode.frames[k].v, 0, this.last));
      this.curve('mean-all').setAttribute('d', this.path((k) => this.means[k], 1, this.last));
      this.go(Math.min(this.step, this.last));
    }

    path(value, from, to) {
      let d = '';
      for (let k = from; k <= to; k++) {
        d += `${d ? 'L' : 'M'}${((k / Math.max(1, this.last)) * 1000).toFixed(1)} ${((1 - value(k)) * 1000).toFixed(1)}`;
      }
      return d;
    }

    toggle() { if (this.playing) this.pause(); else this.play(); }

    play() {
      if (this.playing) return;
      if (this.t >= this.last) this.t = 0;
      this.setPlaying(true);
      let before = null;
      const tick = (now) => {
        if (!this.playing) return;
        // A tab that was in the background goes on where it was.
        const seconds = before === null ? 0 : Math.min((now - before) / 1000, 0.25);
        before = now;
        this.t = Math.min(this.last, this.t + seconds * Number(this.speed.value));
        this.show();
        if (this.t >= this.last) this.pause(); else requestAnimationFrame(tick);
      };
      requestAnimationFrame(tick);
    }

    pause() {
      this.setPlaying(false);
      const { v } = this.episode.frames[this.step];
      this.find('spoken').textContent = `Step ${this.step} of ${this.last}, ${Math.round(v * 100)} % covered`;
    }

    setPlaying(playing) {
      this.playing = playing;
      this.element.classList.toggle('playing', playing);
      this.element.querySelector('[data-do="play"]').setAttribute('aria-label', playing ? 'Pause' : 'Play');
      this.publish();
    }

    go(step) {
      if (this.playing) this.pause();
      this.t = Math.max(0, Math.min(this.last, step));
      this.show();
    }

    key(event) {
      const kind = event.target.tagName;
      if (event.ctrlKey || event.metaKey || event.altKey || kind === 'SELECT') return;
      if (event.key === ' ' && (kind === 'BUTTON' || event.target.type === 'checkbox')) return;
      const far = event.shiftKey ? 10 : 1;
      const act = {
        ' ': () => this.toggle(),
        ArrowLeft: () => this.go(this.step - far),
        ArrowRight: () => this.go(this.step + far),
        Home: () => this.go(0),
        End: () => this.go(this.last),
        '+': () => this.faster(1),
        '=': () => this.faster(1),
        '-': () => this.faster(-1),
        u: () => this.next(1),
        U: () => this.next(-1),
        Escape: () => this.select(null),
      }[event.key];
      if (!act) return;
      event.preventDefault();
      event.stopPropagation();
      act();
    }

    faster(by) {
      const { options, selectedIndex } = this.speed;
      this.speed.selectedIndex = Math.max(0, Math.min(options.length - 1, selectedIndex + by));
    }

    next(by) {
      if (this.count) this.select(((this.selected ?? (by > 0 ? -1 : 0)) + by + this.count) % this.count);
    }

    // The number of a UAV there is, or null.
    uav(text) {
      const i = Number(text);
      return Number.isInteger(i) && i >= 0 && i < this.count ? i : null;
    }

    point(event) {
      const box = this.canvas.getBoundingClientRect();
      const { at } = covey.projection(this.episode, box.width);
      let [best, nearest] = [null, event.pointerType === 'mouse' ? 18 : 30];
      for (let i = 0; i < this.count; i++) {
        const place = covey.placeAt(this.episode, i, this.t);
        if (!place) continue;
        const [x, y] = at(place);
        const distance = Math.hypot(x - (event.clientX - box.left), y - (event.clientY - box.top));
        if (distance < nearest) [best, nearest] = [i, distance];
      }
      this.select(best);
    }

    select(uav) {
      if (uav === this.selected) return;
      this.selected = uav;
      this.redraw();
    }

    show() {
      const frame = this.episode.frames[this.step];
      const count = this.episode.pois.length / 2;
      let covered = 0;
      for (let k = 0; k < count; k++) covered += covey.isCovered(frame, k);
      const { linked, groups, there } = this.graph(frame);
      this.slider.value = String(this.step);
      this.slider.setAttribute('aria-valuetext', `step ${this.step} of ${this.last}`);
      this.find('step-of').textContent = `${this.step} / ${this.last}`;
      this.find('covered').innerHTML = `${(frame.v * 100).toFixed(1)} % <small>${covered} of ${count}</small>`;
      this.find('index').textContent = this.step ? this.means[this.step].toFixed(3) : '–';
      this.find('linked').innerHTML = `${linked} <small>of ${there}</small>`;
      this.find('groups').textContent = String(groups);
      this.curve('now').setAttribute('d', this.path((k) => this.episode.frames[k].v, 0, this.step));
      this.curve('mean').setAttribute('d', this.path((k) => this.means[k], 1, this.step));
      this.curve('cursor').setAttribute('d', `M${(this.t / Math.max(1, this.last)) * 1000} 0V1000`);
      this.publish();
      this.redraw();
    }

    // UAVs with a neighbour, and connected groups (a lone UAV is one).
    graph(frame) {
      const parent = Array.from({ length: frame.p.length / 2 }, (_, i) => i);
      const find = (i) => { while (parent[i] !== i) i = parent[i]; return i; };
      for (let k = 0; k < frame.l.length; k += 2) parent[find(frame.l[k])] = find(frame.l[k + 1]);
      const there = parent.map((_, i) => i).filter((i) => frame.p[2 * i] !== null);
      return { linked: new Set(frame.l).size, groups: new Set(there.map(find)).size, there: there.length };
    }

    redraw() {
      if (this.queued) return;
      this.queued = true;
      requestAnimationFrame(() => { this.queued = false; this.draw(); });
    }

    draw() {
      const density = globalThis.devicePixelRatio || 1;
      const size = Math.round(this.canvas.clientWidth * density);
      if (!size) return;
      if (this.canvas.width !== size) this.canvas.width = this.canvas.height = size;
      const layers = {};
      for (const box of this.element.querySelectorAll('[data-layer]')) layers[box.dataset.layer] = box.checked;
      const t = still.matches ? this.step : this.t;
      // Symbols shrink on a small screen, but less than the map does.
      const pixel = density * Math.max(0.75, Math.min(1.15, this.canvas.clientWidth / 640));
      const view = { layers, colours: this.colours, selected: this.selected, pixel };
      covey.drawMap(this.canvas.getContext('2d'), size, this.episode, t, view);
      this.label(t);
    }

    // What is known of the selected UAV, beside it.
    label(t) {
      const i = this.selected;
      const place = i === null ? null : covey.placeAt(this.episode, i, t);
      this.tip.hidden = !place;
      if (!place) return;
      const [from, frame] = [this.episode.frames[Math.max(0, this.step - 1)], this.episode.frames[this.step]];
      const speed = Math.hypot(frame.p[2 * i] - from.p[2 * i], frame.p[2 * i + 1] - from.p[2 * i + 1]) / 100;
      const neighbours = frame.l.filter((uav) => uav === i).length;
      const action = frame.a ? this.episode.actions[frame.a[i]] ?? `action ${frame.a[i]}` : null;
      const lines = [
        `${place[0].toFixed(1)} u east, ${place[1].toFixed(1)} u north`,
        `${speed.toFixed(1)} u/step, ${neighbours} ${neighbours === 1 ? 'neighbour' : 'neighbours'}`,
        ...(action === null ? [] : [action]),
      ];
      const head = Object.assign(document.createElement('b'), { textContent: `UAV ${i}` });
      this.tip.replaceChildren(head, ...lines.map((text) => Object.assign(document.createElement('div'), { textContent: text })));
      const width = this.canvas.clientWidth;
      const [x, y] = covey.projection(this.episode, width).at(place);
      const { offsetWidth, offsetHeight } = this.tip;
      if (width < 480) {
        // No room beside the UAV: the half of the map that it is not in.
        this.tip.style.left = '6px';
        this.tip.style.top = `${y < width / 2 ? width - offsetHeight - 8 : 6}px`;
        return;
      }
      this.tip.style.left = `${x + 16 + offsetWidth > width ? Math.max(0, x - 16 - offsetWidth) : x + 16}px`;
      this.tip.style.top = `${Math.max(4, Math.min(width - offsetHeight - 4, y - offsetHeight / 2))}px`;
    }

    publish() {
      if (players.length && players[0] !== this) return;
      root.dataset.step = String(this.step);
      root.dataset.coverage = this.find('covered').textContent;
      root.dataset.playing = this.playing ? '1' : '0';
    }
  }

  for (const element of document.querySelectorAll('[data-player]')) players.push(new Player(element));
  active = players[0] ?? null;
  // With nothing in focus the keys go to the player that was used last.
  addEventListener('keydown', (event) => { if (event.target === document.body) active?.key(event); });

  const { settings } = covey;
  if (active) {
    const chosen = Number(settings.get('episode')) - 1;
    if (active.episodes[chosen]) active.choose(chosen);
    if (settings.has('step')) active.go(Number(settings.get('step')) || 0);
    if (settings.has('uav')) active.select(active.uav(settings.get('uav')));
    if (settings.has('play')) active.play();
  }
  root.dataset.ready = '1';
})();
