// The pixels of a page: unpacking (pixel_data.h describes the format), means over blocks, and conversion from linear
// light to the colours of a screen.
const raylexPixels = (() => {
  const halfValue = new Float32Array(65536);
  for (let h = 0; h < 65536; ++h) {
    const exponent = h >> 10 & 31, fraction = h & 1023;
    const value = exponent === 0 ? fraction * 2 ** -24 : exponent === 31 ? (fraction ? NaN : Infinity)
      : (1 + fraction / 1024) * 2 ** (exponent - 15);
    halfValue[h] = h & 32768 ? -value : value;
  }

  const made = new Map();
  const once = (key, make) => {
    if (!made.has(key)) made.set(key, make());
    return made.get(key);
  };
  const inflated = async text => {
    const raw = atob(text), packed = new Uint8Array(raw.length);
    for (let i = 0; i < raw.length; ++i) packed[i] = raw.charCodeAt(i);
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('deflate'));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  };
  const unpacked = id => inflated(document.getElementById(id).textContent);

  // The values of an image, plane after plane: `at(i)` is value i.
  const halves = (id, scale = 1) => once(id, async () => {
    const bytes = await unpacked(id), count = bytes.length / 2, words = new Uint16Array(count);
    for (let i = 0, high = 0; i < count; ++i) words[i] = (high = high + bytes[i] & 255) << 8 | bytes[count + i];
    return { count, at: i => halfValue[words[i]] * scale };
  });
  const integersOf = async text => {
    const b = await inflated(text), count = b.length / 4;
    return { count, at: i => ((b[i] << 24 | b[count + i] << 16 | b[2 * count + i] << 8 | b[3 * count + i]) >>> 0) };
  };
  const integers = id => once(id, () => integersOf(document.getElementById(id).textContent));

  // Means over level x level pixels of three planes. A value that is not finite makes the mean not finite, and so stays
  // visible. The latest results are kept, because a change of exposure needs them again.
  const kept = new Map();
  const reduced = (key, planes, width, height, level) => {
    const name = `${key}@${level}`;
    let result = kept.get(name);
    if (!result) {
      const w = Math.ceil(width / level), h = Math.ceil(height / level), pixels = width * height;
      const values = new Float32Array(3 * w * h);
      for (let c = 0; c < 3; ++c)
        for (let y = 0; y < h; ++y)
          for (let x = 0; x < w; ++x) {
            const right = Math.min(width, (x + 1) * level), down = Math.min(height, (y + 1) * level);
            let sum = 0, count = 0;
            for (let v = y * level; v < down; ++v)
              for (let u = x * level; u < right; ++u, ++count) sum += planes.at(c * pixels + v * width + u);
            values[c * w * h + y * w + x] = sum / count;
          }
      result = { width: w, height: h, level, values };
    }
    kept.delete(name);
    kept.set(name, result);
    if (kept.size > 48) kept.delete(kept.keys().next().value);
    return result;
  };

  const curve = new Uint8ClampedArray(4097);  // the sRGB transfer function
  for (let i = 0; i <= 4096; ++i) {
    const v = i / 4096;
    curve[i] = Math.round(255 * (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055));
  }
  const broken = [255, 0, 255];  // the colour of what is not finite
  const srgb = (data, q, r, g, b) => {
    data[q] = r > 0 ? curve[Math.min(4096, Math.round(r * 4096))] : 0;
    data[q + 1] = g > 0 ? curve[Math.min(4096, Math.round(g * 4096))] : 0;
    data[q + 2] = b > 0 ? curve[Math.min(4096, Math.round(b * 4096))] : 0;
  };

  // A view of the colour config: linear interpolation in a table whose nodes are logarithmically spaced.
  const view = id => once(id, async () => {
    const table = await unpacked(id), n = Math.round(Math.cbrt(table.length / 3)), least = 2 ** -10;
    const place = v => Math.min(n - 1, v > 0 ? 2 * (Math.log2(v + least) + 10) : 0);
    return (data, q, r, g, b) => {
      const x = place(r), y = place(g), z = place(b);
      const i = Math.min(n - 2, x | 0), j = Math.min(n - 2, y | 0), k = Math.min(n - 2, z | 0);
      const u = x - i, v = y - j, w = z - k, row = 3 * n, slab = row * n;
      let at = 3 * i + row * j + slab * k;
      for (let c = 0; c < 3; ++c, ++at) {
        const near = (table[at] * (1 - u) + table[at + 3] * u) * (1 - v) +
          (table[at + row] * (1 - u) + table[at + row + 3] * u) * v;
        const far = (table[at + slab] * (1 - u) + table[at + slab + 3] * u) * (1 - v) +
          (table[at + slab + row] * (1 - u) + table[at + slab + row + 3] * u) * v;
        data[q + c] = Math.round(near * (1 - w) + far * w);
      }
    };
  });

  // A canvas of `image`, which `reduced` returned. color(data, q, i) sets the three bytes at q from pixel i.
  const painted = (image, color) => {
    const canvas = Object.assign(document.createElement('canvas'), { level: image.level });
    canvas.width = image.width;
    canvas.height = image.height;
    const context = canvas.getContext('2d'), pixels = context.createImageData(image.width, image.height);
    for (let i = 0, q = 0; i < image.width * image.height; ++i, q += 4) {
      pixels.data[q + 3] = 255;
      color(pixels.data, q, i);
    }
    context.putImageData(pixels, 0, 0);
    return canvas;
  };
  const light = (image, gain, tone) => {
    const { values } = image, count = image.width * image.height;
    return painted(image, (data, q, i) => {
      const r = values[i] * gain, g = values[count + i] * gain, b = values[2 * count + i] * gain;
      if (Number.isFinite(r + g + b)) tone(data, q, r, g, b);
      else data.set(broken, q);
    });
  };

  const digits = v => Number.isNaN(v) ? 'NaN' : Number.isFinite(v) ? String(+v.toPrecision(3)) : v > 0 ? 'inf' : '-inf';
  return { inflated, unpacked, halves, integers, integersOf, reduced, srgb, view, painted, light, digits, broken };
})();
