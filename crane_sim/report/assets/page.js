"use strict";
// The page: fills in what the run holds, and plays it.

(() => {
  const run = JSON.parse(document.getElementById("run").textContent);
  const get = (id) => document.getElementById(id);
  const frames = new Frames(run.frames);
  const clock = { t: run.failure_window_start ?? 0, playing: false, speed: 1, start: run.failure_window_start ?? 0, before: 0 };
  const end = Math.max(...[frames, ...(run.ghosts ?? []).map((ghost) => new Frames(ghost.frames))].map((each) => each.t[each.t.length - 1]));
  let view = null, charts = [], showsLast = run.failure_window_start !== null;

  function fillHead() {
    get("name").textContent = run.name.replaceAll("_", " ");
    get("about").textContent = run.about ?? [run.description, `${run.kind} crane, law ${run.law}`].filter(Boolean).join(" — ");
    for (const [name, color] of run.legend ?? []) html("span", get("about"), `  ■ ${name}`).style.color = color;
    get("status").textContent = run.legend ? "comparison" : run.finished ? "finished" : "failed";
    get("status").classList.toggle("bad", !run.finished);
    if (!run.finished) {
      get("failure").hidden = false;
      html("strong", get("failure"), run.error);
      if (run.failure_window_start !== null) html("span", get("failure"), `The view and the curves begin with the last ${(run.end - run.failure_window_start).toFixed(1)} s before it.`);
    }
    if (run.real_time_violation) {
      get("failure").hidden = false;
      html("strong", get("failure"), `${run.real_time_violation}; its motion and metrics are also those of the machine.`);
    }
    for (const [name, value] of run.headlines) {
      const card = html("div", get("headlines"));
      html("dt", card, name);
      html("dd", card, value);
    }
  }

  function fillTable(table, rows, head = false) {
    if (!rows.length) table.remove();
    rows.forEach((row, i) => {
      const line = html("tr", table);
      for (const value of row) html(head && i === 0 ? "th" : "td", line, value);
    });
  }

  function fillEvents() {
    if (!run.events.length) get("events-section").remove();
    for (const [t, what] of run.events) {
      const line = html("li", get("events"));
      html("button", line, `${t.toFixed(3)} s`, { onclick: () => seek(t) });
      line.append(what);
      const mark = html("i", get("marks"), "", { title: `${t.toFixed(3)} s: ${what}` });
      mark.style.left = `${(100 * Math.min(t, end)) / (end || 1)}%`;
    }
    const more = run.event_count - run.events.length;
    if (more > 0 && run.events.length) html("li", get("events"), `and ${more} more`);
  }

  function makeCharts() {
    get("charts").replaceChildren();
    charts = (showsLast ? run.failure_window_panels : run.panels).map((panel) => new Chart(get("charts"), panel, run.events, seek));
    const [first, count] = frames.parts.nodes;
    const moves = (k) => {
      const [low, high] = limits(frames.columns[first + count - 3 + k]);
      return high - low > 1e-9;
    };
    if (moves(0) || moves(1)) if (moves(1)) charts.push(new PathChart(get("charts"), frames, "Path of the payload from above", 0, 1));
    charts.push(new PathChart(get("charts"), frames, "Path of the payload from the side", 0, 2));
    if (run.states.length) charts.push(new StateChart(get("charts"), run.states, seek));
    drawCharts();
  }

  function drawCharts() {
    const range = showsLast ? [run.failure_window_start, run.end] : [0, run.end];
    for (const chart of charts) {
      chart.draw(Math.max(240, chart.figure.clientWidth || 560), range);
      chart.show(clock.t);
    }
  }

  function seek(t) {
    clock.t = Math.min(Math.max(t, 0), end);
    get("scrub").value = clock.t;
    get("clock").textContent = `${clock.t.toFixed(2)} / ${end.toFixed(2)} s`;
    for (const chart of charts) chart.show(clock.t);
    if (view) view.move(clock.t);
  }

  function play(on) {
    clock.playing = on;
    get("play").textContent = on ? "❚❚" : "▶";
    if (!on) return;
    if (clock.t >= end) seek(clock.start);
    clock.before = performance.now();
    requestAnimationFrame(advance);
  }

  function advance(now) {
    if (!clock.playing) return;
    seek(clock.t + 0.001 * (now - clock.before) * clock.speed);
    clock.before = now;
    if (clock.t >= end) play(false);
    else requestAnimationFrame(advance);
  }

  function connect() {
    const scrub = get("scrub");
    scrub.max = end;
    scrub.addEventListener("input", () => seek(Number(scrub.value)));
    get("play").onclick = () => play(!clock.playing);
    for (const speed of [0.1, 0.25, 0.5, 1, 2, 4, 8]) html("option", get("speed"), `${speed} ×`, { value: speed, selected: speed === 1 });
    get("speed").onchange = () => (clock.speed = Number(get("speed").value));
    get("reset").onclick = () => { view?.resetView(); seek(clock.t); };
    get("follow").onclick = () => {
      if (!view) return;
      view.following = !view.following;
      get("follow").classList.toggle("on", view.following);
    };
    get("span").hidden = run.failure_window_start === null;
    for (const button of get("span").children) {
      if (button.dataset.span === "last") button.textContent = `last ${(run.end - (run.failure_window_start ?? 0)).toFixed(1)} s`;
      button.onclick = () => chooseSpan(button.dataset.span);
    }
    document.addEventListener("keydown", (event) => {
      if (event.target !== document.body) return;
      const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      if (event.key === " ") play(!clock.playing);
      else if (step) seek(clock.t + step * (event.shiftKey ? 1 : 0.1));
      else return;
      event.preventDefault();
    });
    window.addEventListener("beforeprint", () => document.querySelectorAll("details").forEach((each) => (each.open = true)));
    new ResizeObserver(() => { drawCharts(); view?.resize(); }).observe(document.body);
  }

  function chooseSpan(name) {
    showsLast = name === "last";
    clock.start = showsLast ? run.failure_window_start : 0;
    for (const button of get("span").children) button.classList.toggle("on", button.dataset.span === name);
    makeCharts();
  }

  function makeView() {
    try {
      view = new CraneView(get("canvas"), run, frames);
      get("follow").classList.toggle("on", view.following);
      view.resize();
    } catch (error) {
      get("no-view").hidden = false;
      get("no-view").textContent = `This browser draws no 3D here (WebGL is off): ${error.message}`;
    }
  }

  fillHead();
  fillEvents();
  fillTable(get("headed_table"), run.headed_table, true);
  fillTable(get("plain_table"), run.plain_table);
  fillTable(get("origin"), run.origin);
  get("scene").textContent = run.scene;
  makeView();
  connect();
  if (run.failure_window_start === null) makeCharts();
  else chooseSpan("last");
  play(false);
  seek(clock.t);

  // For programs: the instants of the frames, and where things are drawn at any instant.
  window.crane = {
    times: frames.t,
    seek,
    payload: (t) => frames.at("nodes", frames.locate(t)).slice(-3),
    tip: (t) => frames.at("nodes", frames.locate(t)).slice(0, 3),
    link: (name, t, crane = 0) => { seek(t); return view.positionOf(name, crane); },
    drawn: () => view !== null,
  };
})();
