"use strict";
// The frames of the 3D scene: columns of numbers, and what they are at any instant.

function decodeBytes(text) {
  return Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0)).buffer;
}

function decodeFloats(text) {
  return new Float32Array(decodeBytes(text));
}

class Frames {
  constructor({ rows, scales, data, columns, moving }) {
    const integers = new Int32Array(decodeBytes(data));
    let first = 0;
    const decode = ([offset, scale]) => {
      const values = new Float64Array(rows).fill(offset);
      if (scale === 0) return values;
      for (let i = 0; i < rows; i++) values[i] += scale * integers[first + i];
      first += rows;
      return values;
    };
    this.columns = scales.map(decode);
    this.parts = columns; // [first column, number of columns] by name
    this.moving = moving; // coordinates in the part "q"
    this.t = this.columns[0];
  }

  has(name) {
    return name in this.parts;
  }

  // Return [row, share of the next row] at time t.
  locate(t) {
    let low = 0, high = this.t.length - 1;
    if (high <= 0 || t <= this.t[0]) return [0, 0];
    if (t >= this.t[high]) return [high, 0];
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (this.t[middle] <= t) low = middle;
      else high = middle;
    }
    return [low, (t - this.t[low]) / (this.t[high] - this.t[low])];
  }

  // Return the numbers of a part at [row, share].
  at(name, [row, share]) {
    const [first, count] = this.parts[name];
    const numbers = new Array(count);
    for (let i = 0; i < count; i++) {
      const column = this.columns[first + i];
      numbers[i] = share === 0 ? column[row] : column[row] + share * (column[row + 1] - column[row]);
    }
    return numbers;
  }
}
