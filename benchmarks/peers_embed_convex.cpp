// Runs geometry-central's convex embedding on a metric from a file; see peers.py.
//
//     peers_embed_convex INPUT OUTPUT TOLERANCE
//
// INPUT: int64 V, F; int64 corners (F, 3); double lengths of the sides (F, 3), the first from corner 0 to 1.
// OUTPUT: int64 V; double points (V, 3).  A TOLERANCE of 0 means geometry-central's own.
// Prints: success (0 or 1), seconds of processor time, largest edge error over the mean length.

#include "geometrycentral/surface/embed_convex.h"

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
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
  const std::vector<int64_t> sizes = numbers<int64_t>(file, 2);
  const std::vector<int64_t> corners = numbers<int64_t>(file, 3 * sizes[1]);
  const std::vector<double> sides = numbers<double>(file, 3 * sizes[1]);

  std::vector<std::vector<size_t>> polygons;
  for (size_t f = 0; f < corners.size(); f += 3) {
    polygons.push_back({size_t(corners[f]), size_t(corners[f + 1]), size_t(corners[f + 2])});
  }
  const clock_t start = clock();
  ManifoldSurfaceMesh mesh(polygons);
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
  ConvexEmbedder embedder(mesh, lengths, options);
  const bool success = embedder.init() && embedder.embed();
  if (success) embedder.refreshVertexCoordinates();
  const double seconds = double(clock() - start) / CLOCKS_PER_SEC;

  double worst = NAN;
  std::ofstream written(arguments[2], std::ios::binary);
  if (success) {
    double total = 0.;
    worst = 0.;
    for (Edge edge : embedder.currentMesh->edges()) {
      const double length = embedder.intrinsicTriangulation->edgeLengths[edge];
      const Vector3 along = embedder.embedding[edge.secondVertex()] - embedder.embedding[edge.firstVertex()];
      worst = std::fmax(worst, std::fabs(norm(along) - length));
      total += length;
    }
    worst /= total / embedder.currentMesh->nEdges();
    const int64_t count = sizes[0];
    written.write(reinterpret_cast<const char*>(&count), sizeof count);
    for (Vertex vertex : embedder.currentMesh->vertices()) {
      written.write(reinterpret_cast<const char*>(&embedder.embedding[vertex]), 3 * sizeof(double));
    }
  }
  std::printf("\n%d %.6f %.17g\n", int(success), seconds, worst);
}
