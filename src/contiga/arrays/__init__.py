"""Arrays as kernels take them, numbers of statuses, sums of one order, threads and memory."""
