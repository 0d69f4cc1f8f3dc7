/* The coefficients of the Radau IIA collocation of 7 stages, order 13, computed with 80 digits and
 * rounded.
 * Leaves to others: steps (method_radau).
 * Invariant: the last node is 1, so that the last stage is the end of the step. */
#pragma once

enum { RADAU_STAGES = 7, RADAU_POLES = (RADAU_STAGES + 1) / 2 };

static const double radau_node[RADAU_STAGES] = {
    0x1.e05201f8c2062p-6, 0x1.2f43d53682496p-3, 0x1.591283c00a7e2p-2, 0x1.1e0a317ca931cp-1,
    0x1.89d90550ca2b2p-1, 0x1.da989f7ef95f1p-1, 0x1.0000000000000p+0};

/* a_ij, the integral of the j-th Lagrange polynomial from 0 to node i */
static const double radau_through[RADAU_STAGES][RADAU_STAGES] = {
    {0x1.339439878c040p-5, -0x1.cc0a796388665p-7, 0x1.533d7e60f7a16p-7, -0x1.0b54f84016f6ep-7,
     0x1.a2abccaf980e9p-8, -0x1.2d9e3b007fb24p-8, 0x1.df7241f37c4edp-10},
    {0x1.4848d89e338e7p-4, 0x1.4c07bc1c40287p-4, -0x1.5bf69865d58f0p-6, 0x1.cac2f480aa399p-7,
     -0x1.4f5a928186d41p-7, 0x1.d4cf3ae0d0d66p-8, -0x1.70a8843d67503p-9},
    {0x1.272c6b9d6de7dp-4, 0x1.5e5915f04a5dcp-3, 0x1.c0fb337b7a802p-4, -0x1.935f39fa17c80p-6,
     0x1.e3ab045717476p-7, -0x1.39c318fadf2ccp-7, 0x1.e162a3357877dp-9},
    {0x1.361693f89245cp-4, 0x1.3b939e87c4fffp-3, 0x1.d11ddc6d709b8p-3, 0x1.e130ceb5140a4p-4,
     -0x1.861dd8fa6f242p-6, 0x1.a07b161990080p-7, -0x1.2e0b9375e30a2p-8},
    {0x1.2ebeb545c9676p-4, 0x1.4a74cf0de4b92p-3, 0x1.a7aa0328a3e17p-3, 0x1.e563fc8a8784fp-3,
     0x1.a63e566e09258p-4, -0x1.34e7fdc37e032p-6, 0x1.7ff80c13e0dccp-8},
    {0x1.31fe759e0499cp-4, 0x1.443693ea05bdep-3, 0x1.b69611ea12931p-3, 0x1.c24f5110ef0fep-3,
     0x1.970b5a3508124p-3, 0x1.1bb624822fe97p-4, -0x1.09f202e443882p-7},
    {0x1.3120de1741e20p-4, 0x1.45d7547e674b8p-3, 0x1.b2e58c2545d3dp-3, 0x1.c9d728b559d1fp-3,
     0x1.8617b942de854p-3, 0x1.e9f01a14371c2p-4, 0x1.4e5e0a72f0539p-6}};

/* The difference between the embedded formula of order 7 and the method, as weights of the stages'
 * differences from the start. The embedded formula also weights the start, with 1 / pole 0. */
static const double radau_error[RADAU_STAGES] = {
    -0x1.85654a688eb48p+2, 0x1.9109ce7a843edp-1, -0x1.0dea9380f9cabp-2, 0x1.037ad745feb89p-3,
    -0x1.287d04fecc672p-4, 0x1.633c181312f96p-5, -0x1.05e6d3d24d00fp-6};

/* Eigenvalues of the inverse of a: the real eigenvalue (pole 0) and, of each complex pair, the
 * eigenvalue with positive imaginary part; real and imaginary parts. Its left eigenvectors are
 * `to`, its right eigenvectors `from`, as [pole][stage]; the product of a left and its right
 * eigenvector is 1, and the last entries of `from` are 1. */
static const double radau_pole[2][RADAU_POLES] = {
    {0x1.1dfa88c180ab2p+3, 0x1.1060f36d58ac5p+3, 0x1.c9070c7855d36p+2, 0x1.183c83eb7828ep+2},
    {0x0.0p+0, 0x1.a3f841231a708p+1, 0x1.a7dffc016913ep+2, 0x1.456e209c08037p+3}};
static const double radau_to[2][RADAU_POLES][RADAU_STAGES] = {
    {{0x1.c707d62ee24b7p+7, 0x1.4d4bc999d2ea0p+7, 0x1.5a1f04ce35ac3p+5, 0x1.cfc16a45f60dep+1,
      0x1.c94d68af5b718p+1, -0x1.5f2cdae07fe1fp+1, 0x1.7392758f0ebd1p+0},
     {-0x1.2b2fadf366499p+7, -0x1.e614dc93b471dp+6, -0x1.86378257c6165p+4, -0x1.04f3337537c1dp+0,
      0x1.ac6e71a216dacp-1, -0x1.165e250234761p-1, 0x1.cdcad9a779fadp-2},
     {0x1.2ab69cb9b4fafp+5, 0x1.5da2652648b85p+5, 0x1.018bd116bd6c7p+1, -0x1.db7ec5f94a2b3p+0,
      -0x1.b70d51da000b0p+0, 0x1.592a58ae16d32p+0, -0x1.e09c55d592e7bp-2},
     {-0x1.80f2293c0d772p+0, -0x1.6081f9942d45ap+2, 0x1.7ce06cd71790ap-1, 0x1.10b08f288bdf3p+0,
      -0x1.d0ee9f4ccda7cp-1, 0x1.226329670693ap-1, -0x1.a8a6dde0091a8p-3}},
    {{0x1.8780000000000p-263, 0x1.8fa0800000000p-263, 0x1.4de0000000000p-266,
      -0x1.ad40000000000p-268, -0x1.1000000000000p-274, 0x1.2b00000000000p-271,
      -0x1.8760000000000p-272},
     {-0x1.744e56c68a22bp+5, 0x1.7e1b292a9dd8ep+3, 0x1.3a3b25d212a3fp+4, 0x1.cc71ff4ec2bd5p+2,
      -0x1.c1560ba4057bep+0, 0x1.37400f3fa8d28p+1, -0x1.1f8cbeff4fc49p+0},
     {0x1.d2da2bcc78274p+4, -0x1.42336571722f3p+2, -0x1.e5dcba8c07172p+3, -0x1.0520166134e55p-1,
      -0x1.cc764af9f9754p-5, 0x1.e4010999a0feap-1, -0x1.f17bee32b5008p-2},
     {-0x1.0e248ffbfbff9p+2, -0x1.4d11a61298d05p-2, 0x1.bc33f301cf8e3p+1, -0x1.9a3eff5048cb1p+0,
      0x1.123f77c95c32ap-1, -0x1.6b5dfea9c0fdcp-3, 0x1.78c5c74f5ad34p-5}}};
static const double radau_from[2][RADAU_POLES][RADAU_STAGES] = {
    {{0x1.404915594ff5bp-9, -0x1.dbe161aec270ep-10, 0x1.2dd0c5d07774fp-8, 0x1.24c84f75861c9p-6,
      0x1.0683c3ad482f3p-3, 0x1.0a45fab3ebcc8p-1, 0x1.0000000000000p+0},
     {-0x1.44b423796b1ccp-10, -0x1.179e73af3cd03p-14, -0x1.344e18cac272cp-9, 0x1.984c7172b55a2p-9,
      0x1.a0a2c5e6ea782p-4, 0x1.0b23122b28b41p-1, 0x1.0000000000000p+0},
     {-0x1.09c251d158d33p-8, 0x1.13c2e74335c5ep-7, -0x1.188219b981005p-7, -0x1.32252ceffcfe5p-5,
      0x1.5fb7509be8d64p-8, 0x1.0d9b23131c6f7p-1, 0x1.0000000000000p+0},
     {0x1.615cdded5bb91p-6, -0x1.385fdcb5c18d7p-5, 0x1.d6313419932dbp-5, -0x1.390e05673870bp-5,
      -0x1.fe4f0cac5be13p-3, 0x1.102bdcf5bd592p-1, 0x1.0000000000000p+0}},
    {{0x0.0p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0},
     {0x1.69d6f3976638bp-9, -0x1.a186cc6484147p-9, -0x1.b528d3f9b4dfbp-12, -0x1.9b82ad2c253c3p-6,
      -0x1.854ded613adf0p-4, -0x1.064a956df5512p-3, 0x0.0p+0},
     {-0x1.2224a3e316d81p-8, 0x1.083ce38b117eap-8, 0x1.c5b83bfac2860p-8, -0x1.0df9cd7305315p-7,
      -0x1.8bb245070754ap-3, -0x1.1a25b03d9d468p-2, 0x0.0p+0},
     {-0x1.1fd1e87d8734ep-7, 0x1.60acbeb1e0799p-6, -0x1.e21a8149adf6cp-5, 0x1.536dd24148f21p-3,
      -0x1.1820faaf29e23p-2, -0x1.f1fe9d1a481e0p-2, 0x0.0p+0}}};
