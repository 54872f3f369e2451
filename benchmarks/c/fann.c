/* The 2-3-2 network in FANN (double precision), trained pattern by pattern.
 *
 * FANN stores the weights of a standard network in the flat order of generic.c. Its sigmoid is
 * 1 / (1 + exp(-2 steepness s)), so steepness 0.5 is the plain one. */
#include <doublefann.h>
#include <string.h>

enum { IN = 2, HIDDEN = 3, OUT = 2, WEIGHTS = HIDDEN * (IN + 1) + OUT * (HIDDEN + 1) };

int train(const double *start, double *end, const double *x, const double *y, long patterns,
          long epochs, long repeats, double eta, double mu)
{
    struct fann *net = fann_create_standard(3, IN, HIDDEN, OUT);
    struct fann_train_data *table = fann_create_train(patterns, IN, OUT);
    if (!net || !table || fann_get_total_connections(net) != WEIGHTS) return 1;
    for (long p = 0; p < patterns; p++) {
        memcpy(table->input[p], x + p * IN, IN * sizeof *x);
        memcpy(table->output[p], y + p * OUT, OUT * sizeof *y);
    }
    fann_set_training_algorithm(net, FANN_TRAIN_INCREMENTAL);
    fann_set_train_error_function(net, FANN_ERRORFUNC_LINEAR);
    fann_set_activation_function_hidden(net, FANN_SIGMOID);
    fann_set_activation_function_output(net, FANN_LINEAR);
    fann_set_activation_steepness_hidden(net, 0.5);
    fann_set_activation_steepness_output(net, 1.0);
    fann_set_learning_rate(net, eta);
    fann_set_learning_momentum(net, mu);
    for (long r = 0; r < repeats; r++) {
        memcpy(net->weights, start, WEIGHTS * sizeof *start);
        if (net->prev_weights_deltas) memset(net->prev_weights_deltas, 0, WEIGHTS * sizeof *start);
        for (long e = 0; e < epochs; e++) fann_train_epoch(net, table);
    }
    memcpy(end, net->weights, WEIGHTS * sizeof *end);
    fann_destroy_train(table);
    fann_destroy(net);
    return 0;
}
