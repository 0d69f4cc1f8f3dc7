# Completion of pendulum's command line, for bash.
_pendulum() {
    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]}
    case $before in
    --as) COMPREPLY=($(compgen -W 'csv json npz h5 parquet mat ndjson png bin' -- "$word")) ;;
    --method) COMPREPLY=($(compgen -W 'taylor ode23 rkf45 rk8pd msadams symplectic linear' -- "$word")) ;;
    --unit) COMPREPLY=($(compgen -W 'rad deg' -- "$word")) ;;
    --status) COMPREPLY=($(compgen -W 'accepted running successful failed dismissed' -- "$word")) ;;
    --of) COMPREPLY=($(compgen -W 'first_flip flip_time flips lambda_max lambda_min sign_change energy_drift lyapunov horizon settled' -- "$word")) ;;
    ask) COMPREPLY=($(compgen -W 'trees trajectories forces modes ensembles lyapunov sections response controllers fits tables trials orbits equations' -- "$word")) ;;
    get | cancel) COMPREPLY=($(compgen -W "$(pendulum jobs 2>/dev/null | cut -d' ' -f1)" -- "$word")) ;;
    *)
        if [[ $word = -* ]]; then
            COMPREPLY=($(compgen -W "$(pendulum --help | grep -o -e '--[a-z]*' | sort -u)" -- "$word"))
        elif [ "$COMP_CWORD" = 1 ]; then
            COMPREPLY=($(compgen -W 'run modes map ask jobs get cancel' -- "$word"))
        else
            COMPREPLY=($(compgen -f -- "$word"))
        fi
        ;;
    esac
}
complete -o filenames -F _pendulum pendulum
