// How a view draws numbers: maps with their scales of colours, and spectra. It begins the module that
// `_view.js` ends. The picture is described in `_view_picture.py`.

const SIDE_PX = 320; // the longer side of a panel, and of one of three
const SMALL_SIDE_PX = 250;
const LOG_SPAN = 1e-4; // a logarithmic scale begins at this share of the largest value

// Colours of viridis and magma (S. van der Walt and N. Smith, CC0) at 17 even steps, between which they are
// interpolated.
const VIRIDIS = "44015448186a472d7b4240863b528b33638d2c728e26828e21918c1fa08828ae80" +
  "3fbc735ec96284d44baddc30d8e219fde725";
const MAGMA = "0000040a08221d114736106b51127c6a1c818326819c2e7fb73779d0416fe75263" +
  "f56b5cfc8961fea772fec488fde2a3fcfdbf";

const shades = (hex) => {
  const at = (step, part) => parseInt(hex.slice(6 * step + 2 * part, 6 * step + 2 * part + 2), 16);
  const colours = new Uint8Array(256 * 3);
  for (let i = 0; i < 256; i++) {
    const step = Math.min(15, Math.floor((i / 255) * 16));
    const share = (i / 255) * 16 - step;
    for (let part = 0; part < 3; part++)
      colours[3 * i + part] = Math.round(at(step, part) * (1 - share) + at(step + 1, part) * share);
  }
  return colours;
};

const node = (name, attributes = {}, ...children) => {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
};

const drawn = (name, attributes, text = "") => {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.textContent = text;
  return made;
};

const number = (value, digits = 4) => {
  if (!Number.isFinite(value)) return "no value";
  const size = Math.abs(value);
  if (size !== 0 && (size < 1e-3 || size >= 1e5)) return value.toExponential(digits - 1);
  return String(Number(value.toPrecision(digits)));
};

const withUnit = (text, unit) => (unit ? `${text} ${unit}` : text);

// The arrays of a picture: 32-bit floats, or only their upper 16 bits.
const values = (bytes, scale) => {
  if (!bytes) return null;
  const { buffer, byteOffset, byteLength } = bytes;
  return (count) => {
    const copy = buffer.slice(byteOffset, byteOffset + byteLength);
    let floats = byteLength === 4 * count ? new Float32Array(copy) : null;
    if (!floats) floats = new Float32Array(Uint32Array.from(new Uint16Array(copy), (u) => u << 16).buffer);
    return Float64Array.from(floats, (value) => value * scale);
  };
};

const decode = (picture) => {
  if (!picture.width) return null;
  const count = picture.width * picture.height;
  const array = (name) => values(picture[name], picture[`${name}_scale`])?.(count) ?? null;
  return { ...picture, image: array("image"), error: array("error"), evaluations: array("evaluations") };
};

// From the smallest value, or 0 if that is larger, to the largest; logarithmic from a small share of it.
const rangeOf = (array, isLog) => {
  let [low, high, positive] = [0, -Infinity, Infinity];
  for (const value of array) {
    if (!Number.isFinite(value)) continue;
    low = Math.min(low, value);
    high = Math.max(high, value);
    if (value > 0) positive = Math.min(positive, value);
  }
  if (isLog && high > 0) low = Math.min(Math.max(positive, high * LOG_SPAN), high / 10);
  if (!(low < high)) [low, high] = [0, 1];
  return { low, high, isLog: isLog && low > 0 };
};

const fractionOf = (value, { low, high, isLog }) =>
  isLog ? Math.log(Math.max(value, low) / low) / Math.log(high / low) : (value - low) / (high - low);

const valueAt = (fraction, { low, high, isLog }) =>
  isLog ? low * (high / low) ** fraction : low + fraction * (high - low);

// One map of the picture with its scale of colours.
const makePanel = (colours) => {
  const canvas = node("canvas", { role: "img" });
  const cursor = node("div", { class: "cursor", hidden: "" });
  const pixels = node("div", { class: "pixels" }, canvas, cursor);
  const scale = node("canvas", { class: "scale", width: 256, height: 1, "aria-hidden": "true" });
  const ends = node("div", { class: "ends" });
  const caption = node("figcaption");
  const figure = node("figure", {}, caption, pixels, scale, ends);
  const paint = (context, width, height, indexOf) => {
    const data = context.createImageData(width, height);
    for (let i = 0; i < width * height; i++) {
      const shade = indexOf(i);
      const known = shade >= 0;
      for (let part = 0; part < 3; part++) data.data[4 * i + part] = known ? colours[3 * shade + part] : 128;
      data.data[4 * i + 3] = known ? 255 : 40;
    }
    context.putImageData(data, 0, 0);
  };
  const shadeOf = (value, range) =>
    Number.isFinite(value) ? Math.round(255 * Math.min(1, Math.max(0, fractionOf(value, range)))) : -1;
  return {
    figure, pixels, canvas,
    show(title, array, { width, height, bins }, isLog, unit) {
      caption.textContent = title;
      const zoom = (bins ? SMALL_SIDE_PX : SIDE_PX) / Math.max(width, height);
      figure.style.width = `${Math.max(150, width * zoom)}px`;
      pixels.style.width = `${width * zoom}px`;
      pixels.style.height = `${height * zoom}px`;
      scale.hidden = ends.hidden = !array;
      Object.assign(canvas, { width, height });
      if (!array) return canvas.setAttribute("aria-label", `${title}: not known`);
      const range = rangeOf(array, isLog);
      // Row 0 is the lowest y.
      paint(canvas.getContext("2d"), width, height, (i) =>
        shadeOf(array[(height - 1 - Math.floor(i / width)) * width + (i % width)], range));
      paint(scale.getContext("2d"), 256, 1, (i) => i);
      ends.replaceChildren(...[0, 0.5, 1].map((f) => node("span", {}, number(valueAt(f, range), 3))));
      const unitText = unit ? ` ${unit}` : "";
      const span = `${number(range.low, 3)} to ${number(range.high, 3)}${unitText}`;
      canvas.setAttribute("aria-label", `${title}, ${width} by ${height} pixels, colours ${span}`);
    },
    mark([column, row], { width, height }) {
      cursor.hidden = false;
      const [x, y] = [100 / width, 100 / height];
      const least = "max(5px, ";
      cursor.style.cssText = `left:${column * x}%;top:${(height - 1 - row) * y}%;` +
        `width:${least}${x}%);height:${least}${y}%)`;
    },
  };
};

// The spectrum of a pixel: steps with a band of errors.
const drawSpectrum = (svg, { values: heights, errors, energies, unit, energy_unit: energyUnit }, isLog) => {
  const [left, width, height] = [64, SMALL_SIDE_PX - 64, 0.62 * SMALL_SIDE_PX];
  const size = { width: SMALL_SIDE_PX, height: height + 24 };
  for (const [key, value] of Object.entries(size)) svg.setAttribute(key, value);
  svg.setAttribute("viewBox", `0 -6 ${size.width} ${size.height}`);
  const end = energies.length - 1;
  const errorOf = (i) => errors?.[i] ?? 0;
  const range = rangeOf(heights.flatMap((value, i) => [value, value + errorOf(i)]), isLog);
  // Bins in equal ratios have a logarithmic axis.
  const growth = (energies[end] - energies[end - 1]) / (energies[1] - energies[0]);
  const place = energies[0] > 0 && Math.abs(growth - 1) > 1e-6 ? Math.log : (energy) => energy;
  const [first, last] = [place(energies[0]), place(energies[end])];
  const x = (energy) => left + ((place(energy) - first) / (last - first)) * width;
  const y = (value) => height * (1 - Math.min(1, Math.max(0, fractionOf(value, range))));
  const steps = (of) => heights.flatMap((_, i) =>
    [energies[i], energies[i + 1]].map((energy) => `${x(energy).toFixed(2)},${y(of(i)).toFixed(2)}`));
  const band = [
    ...steps((i) => heights[i] + errorOf(i)),
    ...steps((i) => heights[i] - errorOf(i)).reverse(),
  ];
  const energyText = (energy) => withUnit(number(energy, 3), energyUnit);
  const text = (at, anchor, words) => drawn("text", { ...at, "text-anchor": anchor }, words);
  svg.replaceChildren(
    drawn("rect", { class: "frame", x: left, y: 0, width, height }),
    drawn("polygon", { class: "errors", points: band.join(" ") }),
    drawn("polyline", { class: "values", points: steps((i) => heights[i]).join(" ") }),
    text({ x: left - 4, y: 6 }, "end", number(range.high, 3)),
    text({ x: left - 4, y: height }, "end", number(range.low, 3)),
    text({ x: left, y: height + 15 }, "start", energyText(energies[0])),
    text({ x: left + width, y: height + 15 }, "end", energyText(energies[end])),
  );
  const peak = heights.indexOf(Math.max(...heights));
  svg.setAttribute("aria-label", `Spectrum of the pixel, ${heights.length} bins, largest value ` +
    `${withUnit(number(heights[peak]), unit)} at ${energyText(energies[peak])}`);
};
