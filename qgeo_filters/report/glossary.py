"""What each number of a report means: a sentence that stands beside it."""

from __future__ import annotations

_PER_AREA = "in units of the square root of the area"

_MEANINGS = {
    # maps
    "confident": "whether the map stands clear of others, keeps distances, relates like parts, has one orientation",
    "explanation": "why it is sure, or what is ambiguous",
    "score": f"mean over the area of how far distances change along the map, {_PER_AREA}: 0 where the shape only bends",
    "largest_distortion": f"the same at the worst vertex, {_PER_AREA}",
    "runner_up": f"the same mean of the best other map that was proposed, {_PER_AREA}",
    "margin": "how many times as much the next different map costs: near 1 where two fit equally well",
    "orientation": "near 0.7 and above if left stays left; negative if the map turns it over, as a mirror does",
    "hks_agreement": "how far heat kernels agree along the map: above 0.9 between poses of one shape, 1 at most",
    "c_xy": "how far the first 20 eigenfunctions of the distances differ along the map (paper, sec. 4.2): 0 if equal",
    "vertices_of_y_reached": "vertices of Y that are the image of some vertex of X",
    "vertices_of_x_without_partner": "vertices of X that have no image on Y",
    "overlap_x": "share of the area of X, as it was matched, that has a partner on Y: 1 for whole shapes",
    "overlap_y": "share of the area of Y, as it was matched, that has a partner on X: 1 for whole shapes",
    "mean_error": f"mean distance on Y from the image of a vertex to its true image, {_PER_AREA}",
    "median_error": f"half of the vertices are nearer to their true image than this, {_PER_AREA}",
    "max_error": f"distance of the worst image from the true one, {_PER_AREA}",
    "vertices_with_an_error": "vertices whose truth is known and that have an image",
    # symmetries
    "found": "whether a reflection was found that relates like parts and keeps distances",
    "reason": "what was found, or why nothing was",
    "vertices_on_the_axis": "vertices that are their own mirror image",
    "plane": "of a shape that is its own mirror image in space: unit normal, a point, mean deviation in sqrt(area)",
    "epsilon_of_mirror_images": "root mean square difference of the sum of eq. (3) between mirror points",
    "epsilon_of_all_pairs": "the same between any two points: far larger than between mirror points",
    "k0": "eigenfunctions in the sum of eq. (3)",
    "spectrum_from": "what the eigenfunctions were computed from",
    "regions": "bands of equal area of that sum",
    "largest_share_of_the_bound": "largest difference of that sum, as a share of its bound by the distances: below 1",
    # spectra and distances
    "from": "what the spectrum was computed from",
    "eigenvalues": "of the distance operator, by decreasing magnitude, mesh units cubed",
    "positive_eigenvalues": "how many of them are positive: few, the first among them",
    "multiplets": "numbers of eigenvalues that are equal within their accuracy: their functions may be mixed",
    "shape": "rows and columns",
    "mean": "mean distance, mesh units",
    "max": "largest distance, mesh units",
    "unreachable_pairs": "pairs of vertices in different pieces, or without faces",
    "length": "of the path, in the metric that it was sought in, mesh units",
    "points": "where the path starts, crosses edges, passes vertices and ends",
    "largest_kappa_g": "largest geodesic curvature at a point of the path, radians: 0 where it is straight",
    "converged": "whether the path is certified to be locally shortest",
    "matrix_is_symmetric": "whether the distance from a to b is that from b to a, bit for bit",
    "mean_error_percent": "of the distances against libigl's exact ones",
    "max_error_percent": "the largest such error",
    "map_error_against_the_plane": f"mean distance from each mirror point to that in the plane x = 0, {_PER_AREA}",
    # poses
    "d_s": "D(S), eq. (5): mean of C_XY over all pairs of poses; small for a set of one shape",
    "smallest_c_xy": "of the two poses with the most alike eigenfunctions",
    "largest_c_xy": "of the two poses with the least alike eigenfunctions",
    "c_xy_of_the_baselines": "of the two poses that the others are compared by",
    "maps": "how the poses were brought together",
    "frames": "poses in the animation",
    "apart": f"how far the shapes stand apart in the pose that they share, {_PER_AREA}",
    "mean_edge_change": "mean relative change of the lengths of edges from those at rest: 0 where it only bends",
    "mean_edge_change_of_x": "the same of X, which is followed",
    "largest_mean_edge_change": "the same in the worst frame",
    "folded_edges": "edges at which the surface lies folded onto itself and does not at rest, over all frames",
    "notes": "what was done beside what was asked for",
    "left_out": "files that could not be used, and why",
    # meshes
    "vertices": "points, those without faces included",
    "faces": "triangles",
    "edges": "sides of triangles, each counted once",
    "area": "of all triangles, mesh units squared; its square root is the unit of distortions and errors",
    "pieces": "parts that no edge connects",
    "boundary_loops": "closed rows of edges that have a triangle on one side only: holes and rims",
    "genus": "handles: 0 for a ball, 1 for a cup",
    "manifold": "whether no edge has three triangles and each vertex has one fan of them",
    "repaired": "what was changed before anything was computed",
    "vertices_of_the_file": "before the repair",
    "closed": "whether there is no boundary",
    "oriented": "whether neighbouring triangles agree on which side is out",
    "winding": "which side the triangles look to",
    "euler_characteristic": "vertices − edges + faces: 2 for a ball",
    "nonmanifold_edges": "edges of three or more triangles",
    "nonmanifold_vertices": "vertices where several fans of triangles meet",
    "unwelded_vertices": "vertices that lie on others along seams",
    "unreferenced_vertices": "vertices that no triangle has",
    "faces_without_area": "triangles whose corners lie on a line",
    "edge_length_min": "shortest edge, mesh units",
    "edge_length_mean": "mean edge, mesh units",
    "edge_length_max": "longest edge, mesh units",
    "smallest_angle_degrees": "smallest corner of a triangle: the larger, the better",
    "bounding_box_min": "least coordinates",
    "bounding_box_max": "largest coordinates",
    "attributes": "values that the vertices have, by name",
    "advice": "what --repair would mend",
    # many shapes
    "pairs": "pairs of shapes",
    "not_measured": "pairs that could not be measured",
    "failed": "maps with a mean error above 0.1",
    "mirrored": "maps that are nearer to the mirrored truth",
    "auc": "area under the curve of the share of points within an error, up to 0.1: 1 at best",
    "coverage": "share of the area of Y whose vertices are images",
    "mapped": "share of the vertices of X that have an image",
    "published": "figures of other methods on such pairs",
    "rows": "the pairs one by one",
    "reasons": "why pairs could not be measured",
    "shapes": "shapes that take part",
    "groups": "groups that the shapes were put into",
    "prepared": "shapes with their distances and eigenfunctions in the store",
    "matched": "pairs whose map was found",
    "not_matched": "pairs that could not be matched",
    "matched_again": "pairs that contradicted all others and were matched again from what those say",
    "cpu_seconds": "time that all processors spent on it",
    "landmarks": "points that were placed on one shape",
    "without_image": "landmarks that have no image on a shape",
    "not_sure": "shapes whose map is not sure",
    "explained": "share of the variation that each mode has",
}

_OF_COMMANDS = {
    ("evaluate", "confident"): "maps that the search was sure of",
    ("evaluate", "mean_error"): f"mean over all pairs of the mean error, {_PER_AREA}",
    ("collection report", "confident"): "pairs whose map is sure",
    ("collection common", "vertices"): "vertices that all shapes have",
    ("info", "pieces"): "parts that no edge connects; commands need one, or repair",
}


def meaning(name: str, command: str = "") -> str:
    """What a number of a command's results means, without a full stop; empty for one that is not known.

    Parameters
    ----------
    name : str
        As in result.json.
    command : str
        In which some names mean something of their own.
    """
    if name.startswith("percent_within_"):
        threshold = name.removeprefix("percent_within_")
        return f"vertices within {threshold} sqrt(area) of their true image, per cent"
    return _OF_COMMANDS.get((command, name), _MEANINGS.get(name, ""))
