/* An importer that links several models into one program gives each a function
   prefix, for FMI 2 or FMI 3; then every other global name carries it as well.
   Include before the headers of FMI. */
#ifndef NAMES_H
#define NAMES_H

#if defined(FMI2_FUNCTION_PREFIX) && !defined(FMI3_FUNCTION_PREFIX)
#define FMI3_FUNCTION_PREFIX FMI2_FUNCTION_PREFIX
#elif defined(FMI3_FUNCTION_PREFIX) && !defined(FMI2_FUNCTION_PREFIX)
#define FMI2_FUNCTION_PREFIX FMI3_FUNCTION_PREFIX
#endif

#if defined(FMI2_FUNCTION_PREFIX) && !defined(FMI2_OVERRIDE_FUNCTION_PREFIX) && \
    !defined(FMI3_OVERRIDE_FUNCTION_PREFIX)
#define JOIN_(a, b) a##b
#define JOIN(a, b) JOIN_(a, b)
#define OWN(name) JOIN(FMI2_FUNCTION_PREFIX, name)
#define component_continuous_states   OWN(component_continuous_states)
#define component_direction           OWN(component_direction)
#define component_direction_begin     OWN(component_direction_begin)
#define component_direction_of        OWN(component_direction_of)
#define component_direction_seed      OWN(component_direction_seed)
#define component_enter_events        OWN(component_enter_events)
#define component_exit_initialization OWN(component_exit_initialization)
#define component_find                OWN(component_find)
#define component_free                OWN(component_free)
#define component_get_block           OWN(component_get_block)
#define component_get_nominals        OWN(component_get_nominals)
#define component_given               OWN(component_given)
#define component_leave_events        OWN(component_leave_events)
#define component_may                 OWN(component_may)
#define component_may_set             OWN(component_may_set)
#define component_move                OWN(component_move)
#define component_new                 OWN(component_new)
#define component_opened              OWN(component_opened)
#define component_no_type             OWN(component_no_type)
#define component_refuse              OWN(component_refuse)
#define component_reserve             OWN(component_reserve)
#define component_reset               OWN(component_reset)
#define component_set                 OWN(component_set)
#define component_set_logging         OWN(component_set_logging)
#define component_set_states          OWN(component_set_states)
#define component_set_time            OWN(component_set_time)
#define component_set_times           OWN(component_set_times)
#define component_step                OWN(component_step)
#define component_update              OWN(component_update)
#define component_values              OWN(component_values)
#define delay_arrive                  OWN(delay_arrive)
#define delay_enter                   OWN(delay_enter)
#define delay_free                    OWN(delay_free)
#define delay_next                    OWN(delay_next)
#define delay_reserve                 OWN(delay_reserve)
#define delay_reset                   OWN(delay_reset)
#define feeddrive_model               OWN(feeddrive_model)
#define feeddrive_place               OWN(feeddrive_place)
#define feeddrive_pool                OWN(feeddrive_pool)
#define memory_give                   OWN(memory_give)
#define memory_more                   OWN(memory_more)
#define memory_release                OWN(memory_release)
#define memory_take                   OWN(memory_take)
#define simulation_activate           OWN(simulation_activate)
#define simulation_bad_delay          OWN(simulation_bad_delay)
#define simulation_begin              OWN(simulation_begin)
#define simulation_effort             OWN(simulation_effort)
#define simulation_free               OWN(simulation_free)
#define simulation_not_finite         OWN(simulation_not_finite)
#define simulation_place              OWN(simulation_place)
#define simulation_refresh            OWN(simulation_refresh)
#define simulation_reserve            OWN(simulation_reserve)
#define simulation_reset              OWN(simulation_reset)
#define simulation_size               OWN(simulation_size)
#define simulation_step               OWN(simulation_step)
#define simulation_tangent            OWN(simulation_tangent)
#define simulation_tick               OWN(simulation_tick)
#define simulation_values             OWN(simulation_values)
#define snapshot_read                 OWN(snapshot_read)
#define snapshot_release              OWN(snapshot_release)
#define snapshot_restore              OWN(snapshot_restore)
#define snapshot_size                 OWN(snapshot_size)
#define snapshot_take                 OWN(snapshot_take)
#define snapshot_write                OWN(snapshot_write)
#endif

#if defined(__GNUC__) /* FMI prescribes arguments that nobody needs */
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif
#if defined(__clang__) /* and declares callbacks as () */
#pragma clang diagnostic ignored "-Wstrict-prototypes"
#endif

#endif
