// Draws one moment of an episode on a canvas.
(() => {
  const TRAIL_STEPS = 15;
  const TURN = 2 * Math.PI;

  // Place of UAV i at time t (steps, fractions between), u; null when it is not there.
  covey.placeAt = (episode, i, t) => {
    const step = Math.min(Math.floor(t), episode.frames.length - 1);
    const a = episode.frames[step].p;
    if (a[2 * i] === null) return null;
    const b = (episode.frames[step + 1] || episode.frames[step]).p;
    const f = b[2 * i] === null ? 0 : t - step;
    return [0, 1].map((k) => (a[2 * i + k] + (b[2 * i + k] - a[2 * i + k]) * f) / 100);
  };

  covey.isCovered = (frame, poi) => (parseInt(frame.c[poi >> 2], 16) >> (poi & 3)) & 1;

  // u → pixels of the canvas: north is up, a margin keeps UAVs at the edge whole.
  covey.projection = (episode, size) => {
    const margin = size * 0.025;
    const scale = (size - 2 * margin) / episode.side;
    return { scale, at: ([x, y]) => [margin + x * scale, size - margin - y * scale] };
  };

  // view: layers to draw, colours, the selected UAV or null, and the scale of symbols.
  covey.drawMap = (context, size, episode, t, view) => {
    const { layers, colours, selected, pixel } = view;
    const { scale, at } = covey.projection(episode, size);
    const frame = episode.frames[Math.min(Math.floor(t), episode.frames.length - 1)];
    const uavs = Array.from({ length: frame.p.length / 2 }, (_, i) => covey.placeAt(episode, i, t));
    const there = uavs.filter((p) => p !== null).map(at);
    const circle = (p, radius) => { context.moveTo(p[0] + radius, p[1]); context.arc(p[0], p[1], radius, 0, TURN); };
    const stroke = (colour, width, alpha = 1) => {
      Object.assign(context, { strokeStyle: colour, lineWidth: width * pixel, globalAlpha: alpha });
      context.stroke();
      context.globalAlpha = 1;
    };

    context.fillStyle = colours.map;
    context.fillRect(0, 0, size, size);
    context.beginPath();
    for (let k = 0; k <= 4; k++) {
      const line = (k / 4) * episode.side;
      context.moveTo(...at([line, 0]));
      context.lineTo(...at([line, episode.side]));
      context.moveTo(...at([0, line]));
      context.lineTo(...at([episode.side, line]));
    }
    stroke(colours.grid, 1);

    if (layers.discs) {
      // One path, so that discs that overlap are not darker.
      context.beginPath();
      there.forEach((p) => circle(p, episode.ranges[0] * scale));
      Object.assign(context, { fillStyle: colours.disc, globalAlpha: 0.13 });
      context.fill();
      stroke(colours.disc, 1, 0.4);
    }
    if (layers.trails) drawTrails(context, episode, t, uavs.length, at, (width, alpha) => stroke(colours.uav, width, alpha));
    if (layers.edges) {
      context.beginPath();
      for (let k = 0; k < frame.l.length; k += 2) {
        const [a, b] = [uavs[frame.l[k]], uavs[frame.l[k + 1]]];
        if (a && b) { context.moveTo(...at(a)); context.lineTo(...at(b)); }
      }
      stroke(colours.edge, 1.6, 0.75);
    }
    drawPois(context, episode, frame, at, pixel, colours, circle, stroke);

    if (selected !== null && uavs[selected]) {
      for (const [range, dash, colour] of [[1, [6, 5], colours.uav], [2, [1.5, 4], colours.edge]]) {
        context.beginPath();
        circle(at(uavs[selected]), episode.ranges[range] * scale);
        context.setLineDash(dash.map((d) => d * pixel));
        stroke(colour, 1.5, 0.9);
        context.setLineDash([]);
      }
    }
    uavs.forEach((p, i) => {
      if (p === null) return;
      drawUav(context, at(p), heading(episode, i, t), pixel * (i === selected ? 1.35 : 1), colours);
      if (layers.numbers) {
        Object.assign(context, { fillStyle: colours.uav, font: `${11 * pixel}px system-ui, sans-serif` });
        const [x, y] = at(p);
        context.fillText(String(i), x + 8 * pixel, y - 7 * pixel);
      }
    });
  };

  function drawTrails(context, episode, t, count, at, stroke) {
    const now = Math.floor(t);
    for (let back = Math.max(0, now - TRAIL_STEPS); back <= now; back++) {
      context.beginPath();
      for (let i = 0; i < count; i++) {
        const [from, to] = [covey.placeAt(episode, i, back), covey.placeAt(episode, i, Math.min(back + 1, t))];
        if (from && to) { context.moveTo(...at(from)); context.lineTo(...at(to)); }
      }
      stroke(1.6, 0.06 + 0.34 * (1 - (now - back) / (TRAIL_STEPS + 1)));
    }
  }

  function drawPois(context, episode, frame, at, pixel, colours, circle, stroke) {
    for (const covered of [0, 1]) {
      context.beginPath();
      for (let k = 0; k < episode.pois.length / 2; k++) {
        if (covey.isCovered(frame, k) === covered) {
          circle(at([episode.pois[2 * k] / 100, episode.pois[2 * k + 1] / 100]), (covered ? 3.2 : 2.7) * pixel);
        }
      }
      if (covered) {
        context.fillStyle = colours.covered;
        context.fill();
      } else {
        stroke(colours.open, 1.5);
      }
    }
  }

  // Direction of flight on the canvas, radians; null when the UAV stands.
  function heading(episode, i, t) {
    const step = Math.min(Math.floor(t), Math.max(0, episode.frames.length - 2));
    const [from, to] = [covey.placeAt(episode, i, step), covey.placeAt(episode, i, step + 1)];
    if (!from || !to || Math.hypot(to[0] - from[0], to[1] - from[1]) < 0.05) return null;
    return Math.atan2(from[1] - to[1], to[0] - from[0]);
  }

  function drawUav(context, [x, y], direction, pixel, colours) {
    context.save();
    context.translate(x, y);
    context.beginPath();
    if (direction === null) {
      context.arc(0, 0, 4.6 * pixel, 0, TURN);
    } else {
      context.rotate(direction);
      context.moveTo(8.5 * pixel, 0);
      context.lineTo(-5.5 * pixel, 5.2 * pixel);
      context.lineTo(-3 * pixel, 0);
      context.lineTo(-5.5 * pixel, -5.2 * pixel);
      context.closePath();
    }
    Object.assign(context, { strokeStyle: colours.map, lineWidth: 3 * pixel, lineJoin: 'round', fillStyle: colours.uav });
    context.stroke();
    context.fill();
    context.restore();
  }
})();
