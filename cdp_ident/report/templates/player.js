"use strict";
// The pendulum, measured and simulated, moved from the curves that the charts show.
(() => {
  const scene = window.reportPlayer;
  const element = (id) => document.getElementById(id);
  const [play, scrub, reading] = ["play", "scrub", "reading"].map(element);
  const stages = [...document.querySelectorAll(".stage")];
  const TRAIL = 1.0; // seconds of the tips' paths
  const reach = scene.length + scene.outer_length;
  const SCALE = 80 / reach; // of the drawing's units to a metre: rods of any size beside the same cart and joints

  let curve = scene.trials[0];
  let [place, clock] = [0, 0]; // the sample that is shown; the time that has come [s]
  let [playing, last] = [false, 0];
  const go = (index) => {
    place = index;
    clock = curve.time[index];
  };

  const ends = (index, angles) => {
    const [x, [theta1, theta2]] = [curve.cart[index], angles];
    const joint = [x + scene.length * Math.sin(theta1), scene.length * Math.cos(theta1)];
    const tip = [joint[0] + scene.outer_length * Math.sin(theta2), joint[1] + scene.outer_length * Math.cos(theta2)];
    return { base: [x, 0], joint, tip };
  };
  const drawn = ([x, y]) => `${(SCALE * x).toFixed(2)},${(-SCALE * y).toFixed(2)}`;
  const measuredAt = (index) => curve.measured.map((angle) => angle[index]);
  const simulatedAt = (model) => (index) => {
    const factor = Number(element("factor").value);
    return curve[element("start").value][model].map((angle, k) => {
      const measured = curve.measured[k][index];
      return measured + factor * (angle[index] - measured);
    });
  };
  const show = (group, index, anglesAt) => {
    const rods = ends(index, anglesAt(index));
    const exists = rods.tip.every(Number.isFinite);
    group.style.display = exists ? "" : "none";
    group.dataset.joint = rods.joint.join(",");
    group.dataset.tip = rods.tip.join(",");
    if (!exists) return;
    group.querySelector("path").setAttribute("d", `M${drawn(rods.base)} L${drawn(rods.joint)} L${drawn(rods.tip)}`);
    group.querySelectorAll("circle").forEach((circle, k) => {
      const [x, y] = drawn(k ? rods.tip : rods.joint).split(",");
      circle.setAttribute("cx", x);
      circle.setAttribute("cy", y);
    });
    const points = [];
    for (let k = index; k >= 0 && curve.time[index] - curve.time[k] < TRAIL; k -= 1) {
      const { tip } = ends(k, anglesAt(k));
      if (tip.every(Number.isFinite)) points.push(drawn(tip));
    }
    group.querySelector("polyline").setAttribute("points", points.join(" "));
  };
  const render = () => {
    const time = curve.time[place];
    const measured = measuredAt(place);
    const written = (numbers, digits) => numbers.map((n) => (Number.isFinite(n) ? n.toFixed(digits) : "–"));
    const [theta1, theta2] = written(measured, 3);
    const errors = stages.map((stage) => {
      const { model } = stage.dataset;
      stage.dataset.time = time;
      stage.querySelector(".cart").setAttribute("x", (SCALE * curve.cart[place] - 9).toFixed(2));
      show(stage.querySelector(".measured"), place, measuredAt);
      show(stage.querySelector(".simulated"), place, simulatedAt(model));
      const left = curve[element("start").value][model].map((angle, k) => 1e3 * (measured[k] - angle[place]));
      return `${model} ${written(left, 2).join(", ")}`;
    });
    reading.textContent =
      `t = ${time.toFixed(2)} s · measured θ1 ${theta1}, θ2 ${theta2} rad · less simulated [mrad]: ${errors.join("; ")}`;
    scrub.value = place;
    scrub.setAttribute("aria-valuetext", `${time.toFixed(2)} seconds`);
  };
  const choose = () => {
    curve = scene.trials[Number(element("trial").value)];
    go(0);
    scrub.max = curve.time.length - 1;
    // Room for all that was measured, and the cart.
    let [left, right, bottom, top] = [Infinity, -Infinity, -0.1 * reach, 0.1 * reach];
    curve.time.forEach((_, index) => {
      for (const [x, y] of Object.values(ends(index, measuredAt(index)))) {
        [left, right] = [Math.min(left, x), Math.max(right, x)];
        [bottom, top] = [Math.min(bottom, y), Math.max(top, y)];
      }
    });
    const margin = 0.15 * reach;
    const box = [left - margin, -top - margin, right - left + 2 * margin, top - bottom + 2 * margin];
    const view = box.map((length) => (SCALE * length).toFixed(1)).join(" ");
    stages.forEach((stage) => stage.setAttribute("viewBox", view));
    render();
  };
  const step = (now) => {
    if (!playing) return;
    clock += (Number(element("speed").value) * (now - last)) / 1000;
    last = now;
    if (place >= curve.time.length - 1) go(0);
    while (place < curve.time.length - 1 && curve.time[place + 1] <= clock) place += 1;
    render();
    requestAnimationFrame(step);
  };
  const toggle = () => {
    playing = !playing;
    play.textContent = playing ? "Pause" : "Play";
    if (playing) {
      requestAnimationFrame((now) => {
        last = now;
        step(now);
      });
    }
  };
  play.addEventListener("click", toggle);
  scrub.addEventListener("input", () => {
    go(Number(scrub.value));
    render();
  });
  element("trial").addEventListener("change", choose);
  element("player").addEventListener("change", render);
  element("player").addEventListener("keydown", (event) => {
    if (event.key !== " " || event.target.closest("button, select")) return;
    event.preventDefault();
    toggle();
  });
  choose();
  if (!matchMedia("(prefers-reduced-motion: reduce)").matches) toggle();
})();
