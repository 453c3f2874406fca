// Runs geometry-central's convex embedding on a metric from a file; see peers.py.
//
//     peers_embed_convex INPUT OUTPUT TOLERANCE CONVEXITY
//
// INPUT: int64 F; int64 corners (F, 3); int64 twins (F, 3), half-edges 3 f + k; double lengths (F, 3).
// OUTPUT: double points (V, 3).  CONVEXITY: radians by which edges may be concave.  Of both, 0 means
// geometry-central's own.
// Prints: success (0 or 1), seconds of processor time.

#include "geometrycentral/surface/embed_convex.h"

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <tuple>
#include <vector>

using namespace geometrycentral;
using namespace geometrycentral::surface;

template <typename T> std::vector<T> numbers(std::ifstream& file, size_t count) {
  std::vector<T> found(count);
  file.read(reinterpret_cast<char*>(found.data()), count * sizeof(T));
  return found;
}

int main(int, char** arguments) {
  std::ifstream file(arguments[1], std::ios::binary);
  const size_t count = numbers<int64_t>(file, 1)[0];
  const std::vector<int64_t> corners = numbers<int64_t>(file, 3 * count);
  const std::vector<int64_t> others = numbers<int64_t>(file, 3 * count);
  const std::vector<double> sides = numbers<double>(file, 3 * count);

  std::vector<std::vector<size_t>> polygons(count);
  std::vector<std::vector<std::tuple<size_t, size_t>>> twins(count);
  for (size_t h = 0; h < 3 * count; h++) {
    polygons[h / 3].push_back(corners[h]);
    twins[h / 3].emplace_back(others[h] / 3, others[h] % 3);
  }
  const clock_t start = clock();
  ManifoldSurfaceMesh mesh(polygons, twins);
  EdgeData<double> lengths(mesh);
  size_t side = 0;
  for (Face face : mesh.faces()) {
    for (Halfedge halfedge : face.adjacentHalfedges()) lengths[halfedge.edge()] = sides[side++];
  }

  EmbedConvexOptions options;
  if (const double tolerance = std::atof(arguments[3])) {
    options.embeddingTolerance = options.newtonTolerance = tolerance;
    options.maxSteps = 100;
  }
  if (const double convexity = std::atof(arguments[4])) options.edgeConvexityTolerance = convexity;
  ConvexEmbedder embedder(mesh, lengths, options);
  const bool success = embedder.init() && embedder.embed();
  if (success) embedder.refreshVertexCoordinates();
  const double seconds = double(clock() - start) / CLOCKS_PER_SEC;

  if (success) {
    std::ofstream written(arguments[2], std::ios::binary);
    for (Vertex vertex : embedder.currentMesh->vertices()) {
      written.write(reinterpret_cast<const char*>(&embedder.embedding[vertex]), 3 * sizeof(double));
    }
  }
  std::printf("\n%d %.6f\n", int(success), seconds);
}
