// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

namespace splinevox {

/// Small dense matrix, row-major.
struct Matrix {
  int rows = 0, cols = 0;
  std::vector<double> v;
  Matrix() = default;
  Matrix(int r, int c) : rows(r), cols(c), v(std::size_t(r) * std::size_t(c), 0.0) {}
  double& operator()(int i, int j) { return v[std::size_t(i) * std::size_t(cols) + std::size_t(j)]; }
  double operator()(int i, int j) const { return v[std::size_t(i) * std::size_t(cols) + std::size_t(j)]; }
};

/// a * b. @pre a.cols == b.rows
inline Matrix product(const Matrix& a, const Matrix& b) {
  Matrix out(a.rows, b.cols);
  for (int i = 0; i < a.rows; ++i)
    for (int k = 0; k < a.cols; ++k)
      for (int j = 0; j < b.cols; ++j) out(i, j) += a(i, k) * b(k, j);
  return out;
}

/// The x [a.cols x b.cols] with the smallest |a x - b|, column by column, by Householder reflections: normal
/// equations would square the condition of a Bernstein basis, which is 1e5 at 20 points already.
/// @pre a has full column rank and at least as many rows as columns; b as many rows as a.
inline Matrix least_squares(Matrix a, Matrix b) {
  const int m = a.rows, n = a.cols;
  const auto reflect = [&](Matrix& of, int col, const std::vector<double>& u, double scale, int k) {
    double dot = 0;
    for (int i = k; i < m; ++i) dot += u[std::size_t(i)] * of(i, col);
    for (int i = k; i < m; ++i) of(i, col) -= scale * dot * u[std::size_t(i)];
  };
  for (int k = 0; k < n; ++k) {
    double norm = 0;
    for (int i = k; i < m; ++i) norm += a(i, k) * a(i, k);
    norm = std::sqrt(norm);
    std::vector<double> u(std::size_t(m), 0.0);
    for (int i = k; i < m; ++i) u[std::size_t(i)] = a(i, k);
    u[std::size_t(k)] += u[std::size_t(k)] < 0 ? -norm : norm;
    double length = 0;
    for (int i = k; i < m; ++i) length += u[std::size_t(i)] * u[std::size_t(i)];
    if (length == 0) continue;
    for (int j = k; j < n; ++j) reflect(a, j, u, 2 / length, k);
    for (int j = 0; j < b.cols; ++j) reflect(b, j, u, 2 / length, k);
  }
  Matrix x(n, b.cols);
  for (int j = 0; j < b.cols; ++j)
    for (int i = n - 1; i >= 0; --i) {
      double sum = b(i, j);
      for (int k = i + 1; k < n; ++k) sum -= a(i, k) * x(k, j);
      x(i, j) = sum / a(i, i);
    }
  return x;
}

}  // namespace splinevox
