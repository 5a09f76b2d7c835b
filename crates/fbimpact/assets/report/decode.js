// Numbers of the report: base64 of raw deflate in script elements, arrays of integers in it. The format is that of docs/report.md.
"use strict";

const report = {};

// Bytes of the blob of a name, each decoded once.
report.blobs = new Map();

report.blob = function (name) {
  if (!report.blobs.has(name)) {
    report.blobs.set(name, report.inflated(document.getElementById("blob-" + name).textContent));
  }
  return report.blobs.get(name);
};

report.inflated = async function (text) {
  const coded = atob(text.trim());
  const bytes = new Uint8Array(coded.length);
  for (let i = 0; i < coded.length; i++) bytes[i] = coded.charCodeAt(i);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
};

// Integers of an array as they were before they were sorted into planes; rows of `components` numbers.
report.integers = function (bytes, array) {
  const { offset, count, components, type } = array;
  const width = { i16: 2, u32: 4, f32: 4, u8: 1 }[type];
  if (array.coding === "plain") {
    const part = bytes.slice(offset, offset + width * count);
    return type === "f32" ? new Float32Array(part.buffer) : part;
  }
  const out = type === "i16" ? new Int16Array(count) : new Uint32Array(count);
  const rows = components > 0 ? Math.ceil(count / components) : 0;
  let k = 0;
  for (let c = 0; c < components; c++) {
    let before = 0;
    for (let row = 0; row < rows; row++, k++) {
      let coded = 0;
      for (let plane = width - 1; plane >= 0; plane--) coded = (coded << 8) | bytes[offset + plane * count + k];
      before = (before + ((coded >>> 1) ^ -(coded & 1))) | 0;
      out[row * components + c] = before;
      before = out[row * components + c];
    }
  }
  return out;
};

// Values of an array; `missing` stands for those that are not finite.
report.values = async function (array, missing = NaN) {
  const bytes = await report.blob(array.blob);
  const numbers = report.integers(bytes, array);
  const out = new Float64Array(numbers.length);
  for (let i = 0; i < out.length; i++) {
    const is_missing = array.type === "i16" && numbers[i] === -32768;
    out[i] = is_missing ? missing : array.zero + array.scale * numbers[i];
  }
  return out;
};

// A number with a few digits, as people read it.
report.text = function (x, digits = 4) {
  if (!Number.isFinite(x)) return "–";
  const size = Math.abs(x);
  if (size > 0 && (size < 1e-3 || size >= 1e6)) return x.toExponential(digits - 1).replace(/\.?0+e/, "e");
  return String(Number(x.toPrecision(digits)));
};

// A value with its unit and a prefix.
report.with_unit = function (x, unit) {
  const names = { "-15": "f", "-12": "p", "-9": "n", "-6": "µ", "-3": "m", 0: "", 3: "k", 6: "M", 9: "G", 12: "T" };
  const size = Math.abs(x);
  const power = size > 0 && Number.isFinite(size) ? Math.min(12, Math.max(-15, 3 * Math.floor(Math.log10(size) / 3 + 1e-9))) : 0;
  return report.text(x / 10 ** power) + " " + names[power] + unit;
};
