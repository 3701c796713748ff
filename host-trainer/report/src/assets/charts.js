// Curves: the legend hides and shows them, pointing at a chart reads values off.
(() => {
  const root = document.documentElement;
  const SVG = 'http://www.w3.org/2000/svg';

  document.querySelector('[data-theme-button]').addEventListener('click', () => {
    const dark = root.dataset.theme ? root.dataset.theme === 'dark' : matchMedia('(prefers-color-scheme: dark)').matches;
    root.dataset.theme = dark ? 'light' : 'dark';
    dispatchEvent(new Event('themechange'));
  });

  for (const group of document.querySelectorAll('[data-charts]')) {
    for (const button of group.querySelectorAll('[data-toggle]')) {
      button.addEventListener('click', () => {
        const shown = button.getAttribute('aria-pressed') !== 'true';
        button.setAttribute('aria-pressed', String(shown));
        for (const path of group.querySelectorAll(`[data-series="${button.dataset.toggle}"]`)) {
          path.classList.toggle('off', !shown);
        }
      });
    }
  }

  // Places of a path's corners, 0 to 1000 each way.
  const corners = (path) => (path.getAttribute('d').match(/[ML][^ML]+/g) || []).map((c) => c.slice(1).split(' ').map(Number));

  for (const plot of document.querySelectorAll('[data-plot]')) {
    const [x0, x1, y0, y1] = plot.dataset.plot.split(' ').map(Number);
    const lines = [...plot.querySelectorAll('path.line')];
    if (!lines.length) continue;
    const places = lines.map(corners);
    const cursor = document.createElementNS(SVG, 'path');
    cursor.setAttribute('class', 'cursor off');
    plot.querySelector('svg').append(cursor);
    const tip = document.createElement('div');
    tip.className = 'tip';
    tip.hidden = true;
    plot.append(tip);
    const decimals = Math.min(8, Math.max(0, 3 - Math.ceil(Math.log10(y1 - y0))));
    const format = (v, digits) => v.toLocaleString('en', { minimumFractionDigits: digits, maximumFractionDigits: digits });

    const show = (at) => {
      // The nearest corner of any visible curve decides where the cursor stands.
      let nearest = null;
      const rows = [];
      lines.forEach((line, k) => {
        if (line.classList.contains('off') || !places[k].length) return;
        const corner = places[k].reduce((a, b) => (Math.abs(b[0] - at) < Math.abs(a[0] - at) ? b : a));
        rows.push([line, y0 + (1 - corner[1] / 1000) * (y1 - y0), corner[0]]);
        if (nearest === null || Math.abs(corner[0] - at) < Math.abs(nearest - at)) nearest = corner[0];
      });
      if (nearest === null) return hide();
      cursor.setAttribute('d', `M${nearest} 0V1000`);
      cursor.classList.remove('off');
      const head = document.createElement('b');
      const x = x0 + (nearest / 1000) * (x1 - x0);
      head.textContent = `${plot.dataset.x} ${format(x, x1 - x0 > 20 ? 0 : 2)}`;
      tip.replaceChildren(head);
      // A curve that ends before the cursor has no value there.
      for (const [line, y] of rows.filter((row) => Math.abs(row[2] - nearest) <= 25).sort((a, b) => b[1] - a[1])) {
        const row = document.createElement('div');
        const key = document.createElement('i');
        key.className = [...line.classList].filter((c) => /^s\d$/.test(c)).join(' ');
        row.append(key, `${line.dataset.name} `, Object.assign(document.createElement('b'), { textContent: format(y, decimals).replace('-', '−') }));
        tip.append(row);
      }
      tip.hidden = false;
      const width = plot.clientWidth;
      const left = (nearest / 1000) * width;
      tip.style.left = `${Math.max(-40, Math.min(left > width / 2 ? left - tip.offsetWidth - 12 : left + 12, width - tip.offsetWidth))}px`;
      tip.style.top = '4px';
    };
    const hide = () => { cursor.classList.add('off'); tip.hidden = true; };
    let at = 1000;
    plot.addEventListener('pointermove', (event) => {
      const box = plot.getBoundingClientRect();
      at = Math.max(0, Math.min(1000, ((event.clientX - box.left) / box.width) * 1000));
      show(at);
    });
    plot.addEventListener('pointerleave', hide);
    plot.addEventListener('focus', () => { if (plot.matches(':focus-visible')) show(at); });
    plot.addEventListener('blur', hide);
    plot.addEventListener('keydown', (event) => {
      const by = { ArrowLeft: -20, ArrowRight: 20, Home: -1000, End: 1000 }[event.key];
      if (!by) return;
      event.preventDefault();
      at = Math.max(0, Math.min(1000, at + by));
      show(at);
    });
  }
})();
