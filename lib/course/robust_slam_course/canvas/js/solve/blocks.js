/** Matrices of three rows and columns, as 9 numbers by rows, and vectors of 3. */

/** Return A B. */
function blockProduct(a, b) {
  const product = [];
  for (let row = 0; row < 9; row += 3) {
    for (let column = 0; column < 3; column++) {
      product.push(a[row] * b[column] + a[row + 1] * b[column + 3] + a[row + 2] * b[column + 6]);
    }
  }
  return product;
}

/** Return Aᵀ. */
export function transposedBlock(a) {
  return [a[0], a[3], a[6], a[1], a[4], a[7], a[2], a[5], a[8]];
}

/** Return A Σ Aᵀ. */
export function congruentBlock(a, covariance) {
  return blockProduct(blockProduct(a, covariance), transposedBlock(a));
}

/** Return A v. */
function blockTimes(a, v) {
  return [
    a[0] * v[0] + a[1] * v[1] + a[2] * v[2],
    a[3] * v[0] + a[4] * v[1] + a[5] * v[2],
    a[6] * v[0] + a[7] * v[1] + a[8] * v[2],
  ];
}

/** Return vᵀ A v. */
export function quadraticForm(a, v) {
  const image = blockTimes(a, v);
  return v[0] * image[0] + v[1] * image[1] + v[2] * image[2];
}

/** Return A⁻¹: the adjugate over the determinant. */
export function inverseBlock([a, b, c, d, e, f, g, h, i]) {
  const [first, second, third] = [e * i - f * h, f * g - d * i, d * h - e * g];
  const determinant = a * first + b * second + c * third;
  const adjugate = [
    first, c * h - b * i, b * f - c * e,
    second, a * i - c * g, c * d - a * f,
    third, b * g - a * h, a * e - b * d,
  ];
  return adjugate.map((entry) => entry / determinant);
}
