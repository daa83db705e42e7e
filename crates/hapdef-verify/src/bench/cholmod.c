/* Times CHOLMOD on a matrix and right-hand sides read from a file:
   cholmod_bench FILE METIS|AMD BLOCK
   File, little endian: int64 n, nnz, n_rhs; int32 col_ptr[n + 1], row_idx[nnz]; double
   values[nnz]; int64 start[n_rhs + 1]; int32 rows[start[n_rhs]]; double loads[start[n_rhs]].
   Prints: nnz(L), then processor seconds for analysis, factorisation and all solves, then the
   largest relative residual of the last block. */
#include <cholmod.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return t.tv_sec + 1e-9 * t.tv_nsec;
}

static void *take(FILE *file, size_t size, size_t count)
{
    void *data = malloc(size * count + 1);
    if (!data || fread(data, size, count, file) != count) {
        fprintf(stderr, "the file ends early\n");
        exit(1);
    }
    return data;
}

int main(int argc, char **argv)
{
    if (argc != 4)
        return 2;
    FILE *file = fopen(argv[1], "rb");
    if (!file)
        return 2;
    int64_t *head = take(file, 8, 3);
    int64_t n = head[0], nnz = head[1], n_rhs = head[2];
    cholmod_common common;
    cholmod_start(&common);
    common.supernodal = CHOLMOD_SUPERNODAL;
    common.nmethods = 1;
    common.method[0].ordering = strcmp(argv[2], "METIS") ? CHOLMOD_AMD : CHOLMOD_METIS;
    common.postorder = 1;
    cholmod_sparse *a = cholmod_allocate_sparse(n, n, nnz, 1, 1, -1, CHOLMOD_REAL, &common);
    int32_t *columns = take(file, 4, n + 1), *rows = take(file, 4, nnz);
    double *values = take(file, 8, nnz);
    memcpy(a->p, columns, 4 * (n + 1));
    memcpy(a->i, rows, 4 * nnz);
    memcpy(a->x, values, 8 * nnz);
    int64_t *start = take(file, 8, n_rhs + 1);
    int32_t *load_rows = take(file, 4, start[n_rhs]);
    double *loads = take(file, 8, start[n_rhs]);
    fclose(file);

    double t0 = seconds();
    cholmod_factor *factor = cholmod_analyze(a, &common);
    double t1 = seconds();
    cholmod_factorize(a, factor, &common);
    double t2 = seconds();
    if (common.status != CHOLMOD_OK)
        return 3;

    int64_t block = atoll(argv[3]);
    cholmod_dense *x = NULL, *y = NULL, *e = NULL;
    double solve = 0, residual = 0;
    for (int64_t first = 0; first < n_rhs; first += block) {
        int64_t k = first + block < n_rhs ? block : n_rhs - first;
        cholmod_dense *b = cholmod_zeros(n, k, CHOLMOD_REAL, &common);
        for (int64_t c = 0; c < k; c++)
            for (int64_t i = start[first + c]; i < start[first + c + 1]; i++)
                ((double *)b->x)[c * n + load_rows[i]] += loads[i];
        double t = seconds();
        cholmod_solve2(CHOLMOD_A, factor, b, NULL, &x, NULL, &y, &e, &common);
        solve += seconds() - t;
        if (first + block >= n_rhs) {
            double one[2] = {1, 0}, minus[2] = {-1, 0};
            double size = cholmod_norm_dense(b, 0, &common);
            cholmod_sdmult(a, 0, minus, one, x, b, &common);
            residual = cholmod_norm_dense(b, 0, &common) / size;
        }
        cholmod_free_dense(&b, &common);
    }
    printf("%.0f %.6f %.6f %.6f %.3e\n", common.lnz, t1 - t0, t2 - t1, solve, residual);
    return 0;
}
