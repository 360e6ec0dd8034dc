// The curve of a job: its error against its samples, both logarithmic, the target as a dashed line, and the forecast
// as a cone from the last point to where it should meet the target. Drawn anew when the answer has changed.
// SPDX-License-Identifier: MIT
"use strict";

const CURVE = { height: 300, left: 58, right: 18, top: 16, bottom: 46 };

function shape(name, attributes, text) {
    const node = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const [key, value] of Object.entries(attributes))
        node.setAttribute(key, value);
    if (text !== undefined)
        node.textContent = text;
    return node;
}

// 1, 2, 5 x 10^k inside [low, high]; only 1 x 10^k where these are more than `most`.
function marks(low, high, most) {
    const all = [];
    for (let k = Math.floor(Math.log10(low)); k <= Math.ceil(Math.log10(high)); k++)
        for (const step of [1, 2, 5])
            all.push(step * 10 ** k);
    const inside = all.filter((v) => v >= low * 0.999 && v <= high * 1.001);
    return inside.length > most ? inside.filter((v) => Math.abs(Math.log10(v) % 1) < 1e-9) : inside;
}

// What is shown: ranges of samples per pixel (x) and error (y).
function curveRange(points, target, forecast, pixels) {
    const xs = points.map((p) => p.samples / pixels), ys = points.map((p) => p.error);
    if (target !== null)
        ys.push(target);
    if (forecast)
        xs.push(forecast.samples / pixels, Math.min(forecast.samples_high / pixels, 100 * Math.max(...xs)));
    const pad = 1.25;
    return { x0: Math.min(...xs) / pad, x1: Math.max(...xs) * pad, y0: Math.min(...ys) / pad, y1: Math.max(...ys) * pad };
}

// 500, 2 k, 10 M
const markText = (n) => big(n).replace(/(\.\d*?)0+(?!\d)/, "$1").replace(/\.(?!\d)/, "");

function curveAxes(svg, width, range, x, y) {
    const { height, left, right, top, bottom } = CURVE;
    for (const v of marks(range.x0, range.x1, width / 80))
        svg.append(shape("line", { x1: x(v), x2: x(v), y1: top, y2: height - bottom, class: "grid" }),
            shape("text", { x: x(v), y: height - bottom + 17, "text-anchor": "middle" }, markText(v)));
    for (const v of marks(range.y0, range.y1, 7))
        svg.append(shape("line", { x1: left, x2: width - right, y1: y(v), y2: y(v), class: "grid" }),
            shape("text", { x: left - 7, y: y(v) + 4, "text-anchor": "end" }, percent(v)));
    svg.append(shape("text", { x: (left + width - right) / 2, y: height - 8, "text-anchor": "middle" },
        "samples per pixel"));
}

function curveSummary(points, target, forecast, pixels) {
    const last = points[points.length - 1], parts = [`Error ${percent(last.error)} after ${duration(last.seconds)}`];
    if (target.error !== null)
        parts.push(`target ${percent(target.error)}`);
    if (forecast && forecast.samples > target.spp * pixels) {
        const then = last.error * (target.spp * pixels / last.samples) ** forecast.slope;
        parts.push(`the limit of ${target.spp} spp comes first, at about ${percent(then)}`);
    } else if (forecast && forecast.seconds_left !== null && forecast.seconds_left > 0)
        parts.push(`expected in ${duration(forecast.seconds_left)} `
            + `(${duration(forecast.seconds_left_low)} to ${duration(forecast.seconds_left_high)})`);
    return parts.join(", ") + ".";
}

// Fills `root`, a section, from the answer of /convergence; hides it while there is nothing to see.
function showCurve(root, { pixels, points, target, forecast }) {
    const seen = points.filter((p) => p.error > 0 && p.samples > 0);
    root.hidden = seen.length < 2;
    const width = Math.max(280, Math.min(640, root.clientWidth - 18));
    const key = JSON.stringify([width, seen.length, seen.at(-1), target, forecast]);
    if (root.hidden || root.dataset.key === key)
        return;
    root.dataset.key = key;
    const { height, left, right, top, bottom } = CURVE;
    const range = curveRange(seen, target.error, forecast, pixels);
    const along = (v, a, b) => Math.log(v / a) / Math.log(b / a);
    const x = (v) => left + (width - left - right) * along(Math.min(v, range.x1), range.x0, range.x1);
    const y = (v) => top + (height - top - bottom) * (1 - along(v, range.y0, range.y1));
    const summary = curveSummary(seen, target, forecast, pixels);
    const svg = shape("svg", { width, height, viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": summary, class: "curve" });
    curveAxes(svg, width, range, x, y);
    const last = seen.at(-1), end = [x(last.samples / pixels), y(last.error)];
    if (forecast && target.error !== null && forecast.samples > last.samples) {
        const at = (n) => `${x(n / pixels)},${y(target.error)}`;
        svg.append(shape("polygon", { points: `${end} ${at(forecast.samples_low)} ${at(forecast.samples_high)}`, class: "cone" }),
            shape("polyline", { points: `${end} ${at(forecast.samples)}`, class: "forecast" }));
    }
    if (target.error !== null)
        svg.append(shape("line", { x1: left, x2: width - right, y1: y(target.error), y2: y(target.error), class: "target" }),
            shape("text", { x: left + 6, y: y(target.error) - 6, class: "target-name" }, "target"));
    svg.append(shape("polyline", { points: seen.map((p) => `${x(p.samples / pixels)},${y(p.error)}`).join(" "), class: "line" }));
    for (const p of seen.filter((p) => p.interval?.[0] > 0))
        svg.append(shape("line", { x1: x(p.samples / pixels), x2: x(p.samples / pixels),
            y1: y(Math.max(p.interval[0], range.y0)), y2: y(Math.min(p.interval[1], range.y1)), class: "bar95" }));
    for (const p of seen)
        svg.append(shape("circle", { cx: x(p.samples / pixels), cy: y(p.error), r: 3.2 }));
    field(root, "curve").replaceChildren(svg);
    say(field(root, "summary"), summary);
}
