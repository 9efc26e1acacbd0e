"""Clusters of points: connected regions, and the methods of scikit-learn."""

from __future__ import annotations

from numbers import Real

import numpy as np

from contiga.area.regions import neighbours_of, regions
from contiga.arrays.layout import real
from contiga.errors import InputError
from contiga.extras import require
from contiga.records import FloatArray, IntArray

METHODS = ("auto", "kmeans", "dbscan", "meanshift", "hdbscan")
_KMEANS_STARTS = 10
_SEED = 0


def clusters_of(
    points: FloatArray, method: str = "auto", *, k: int = 1, eps: float = 0.1, min_points: int = 4
) -> IntArray:
    """Return (n,) number of the cluster of each point (n, d), from 0 as they come; −1 for noise.

    Parameters
    ----------
    points : (n, 2) or (n, 3); all of them in contact
    method : "auto" (points joined to neighbours within 1.6 times the larger of their local
        spacings, `contiga.area.regions`), "kmeans" (k clusters; as many as different points where
        those are fewer), "dbscan" (radius `eps`, `min_points` within it, the point itself counted),
        "meanshift" (bandwidth estimated from the points), "hdbscan" (clusters of at least
        `min_points`)
    k : number of clusters of "kmeans"
    eps : radius of "dbscan", length
    min_points : smallest number of points of a cluster of "dbscan" and "hdbscan"

    Raises
    ------
    InputError
        Points that are not (n, d), an unknown method, k < 1, eps ≤ 0, min_points < 1.
    MissingPackageError
        A method of scikit-learn, which is not installed.

    Examples
    --------
    >>> clusters_of([[0, 0], [1, 0], [9, 0], [2, 0], [10, 0]], "kmeans", k=2).tolist()
    [0, 0, 1, 0, 1]
    """
    check_options(method, k, eps, min_points)
    points = np.ascontiguousarray(real(points, "points"), dtype=np.float64)
    if points.ndim != 2:
        raise InputError(
            "points must have one row each", where="points", found=points.shape, allowed="(n, d)"
        )
    n = len(points)
    if n == 0:
        return np.zeros(0, np.int32)
    if n == 1:
        return np.full(1, -1 if method == "dbscan" and min_points > 1 else 0, np.int32)
    if method == "auto":
        return regions(neighbours_of(points), np.arange(n, dtype=np.int32), points)
    label = np.asarray(_sklearn_labels(points, method, k, eps, min_points))
    # Number the clusters in the order of their first points; noise stays −1.
    labels, first, inverse = np.unique(label, return_index=True, return_inverse=True)
    order = np.argsort(np.where(labels < 0, -1, first), kind="stable")
    number = np.empty(len(labels), np.int32)
    number[order] = np.arange(len(labels)) - int((labels < 0).any())
    return number[inverse]


def check_options(method: object, k: object, eps: object, min_points: object) -> None:
    """Refuse invalid options, whether or not the method uses them.

    `method` may be a number of clusters.

    Raises
    ------
    InputError
        An unknown method, a number of clusters < 1, k < 1, eps ≤ 0, min_points < 1.
    MissingPackageError
        Any method but "auto" without scikit-learn.
    """
    if isinstance(method, int | np.integer):
        _check_count(method, "clusters", "clusters")
    elif not isinstance(method, str) or method not in METHODS:
        raise InputError(
            "unknown method of clustering",
            where="clusters",
            found=method,
            allowed=", ".join(map(repr, METHODS)) + ", or a number of clusters",
        )
    if method != "auto":
        require(f"clusters={method!r}", "sklearn")
    _check_count(k, "k", "clusters")
    _check_count(min_points, "min_points", "points")
    if not is_positive(eps):
        raise InputError("the radius must be positive", where="eps", found=eps, allowed="> 0")


def is_positive(value: object) -> bool:
    """Return whether a value is a finite number above zero."""
    return isinstance(value, Real) and 0.0 < float(value) < np.inf


def _check_count(count: object, where: str, noun: str) -> None:
    """Raise `InputError` for a value that is no whole number ≥ 1."""
    if isinstance(count, bool) or not isinstance(count, int | np.integer) or count < 1:
        raise InputError(
            f"{noun} are counted from 1", where=where, found=count, allowed="a whole number ≥ 1"
        )


def _sklearn_labels(
    points: FloatArray, method: str, k: int, eps: float, min_points: int
) -> IntArray:
    """Return (n,) labels by a method of scikit-learn, −1 for noise.

    All points are one cluster for "meanshift" without a bandwidth, and for "hdbscan" with no more
    points than the smallest cluster.
    """
    from sklearn import cluster

    if method == "kmeans":
        n_clusters = min(k, len(np.unique(points, axis=0)))
        model = cluster.KMeans(n_clusters, n_init=_KMEANS_STARTS, random_state=_SEED)
        return model.fit_predict(points)
    if method == "dbscan":
        return cluster.DBSCAN(eps=eps, min_samples=min_points).fit_predict(points)
    if method == "meanshift":
        bandwidth = cluster.estimate_bandwidth(points, quantile=0.3, random_state=_SEED)
        if not bandwidth > 0.0:
            return np.zeros(len(points), np.int32)
        return cluster.MeanShift(bandwidth=bandwidth).fit_predict(points)
    size = max(min_points, 2)
    if len(points) <= size:
        return np.zeros(len(points), np.int32)
    return cluster.HDBSCAN(min_cluster_size=size, copy=True).fit_predict(points)
